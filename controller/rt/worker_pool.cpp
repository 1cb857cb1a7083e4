#include "controller/rt/worker_pool.hpp"

namespace c3rt::rt {

WorkerPool::WorkerPool(int workers) {
  for (int worker = 1; worker < workers; ++worker) {
    threads_.emplace_back([this, worker] { serve(worker); });
  }
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::run(int count, Task task, void* context) noexcept {
  std::unique_lock<std::mutex> lock(mutex_);
  task_ = task;
  context_ = context;
  next_ = 0;
  count_ = count;
  wake_.notify_all();
  work(lock, 0);
  done_.wait(lock, [this] { return busy_ == 0; });
}

void WorkerPool::run_on(void* pool, int count, Task task, void* context) noexcept {
  static_cast<WorkerPool*>(pool)->run(count, task, context);
}

void WorkerPool::serve(int worker) noexcept {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return ending_ || next_ < count_; });
    if (ending_) return;
    work(lock, worker);
  }
}

void WorkerPool::work(std::unique_lock<std::mutex>& lock, int worker) noexcept {
  while (next_ < count_) {
    const int index = next_++;
    ++busy_;
    lock.unlock();
    task_(context_, index, worker);
    lock.lock();
    --busy_;
  }
  if (busy_ == 0) done_.notify_one();
}

}  // namespace c3rt::rt
