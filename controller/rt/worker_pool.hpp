#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace c3rt::rt {

/// Threads that share out a counted loop; the caller is one of them. Not for the servo path: it
/// locks and waits.
class WorkerPool {
 public:
  using Task = void (*)(void* context, int index, int worker) noexcept;

  /// @param workers 1 or more, the caller included
  explicit WorkerPool(int workers);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int workers() const noexcept { return static_cast<int>(threads_.size()) + 1; }

  /// task(context, i, worker) once for each i < count; returns when all have ended. One call at a
  /// time. No heap.
  void run(int count, Task task, void* context) noexcept;

  /// `run` with the pool as a pointer, for c3::Parallel.
  static void run_on(void* pool, int count, Task task, void* context) noexcept;

 private:
  void serve(int worker) noexcept;
  /// Takes indices until there are none left. Returns with `lock` held.
  void work(std::unique_lock<std::mutex>& lock, int worker) noexcept;

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  Task task_ = nullptr;
  void* context_ = nullptr;
  int count_ = 0, next_ = 0, busy_ = 0;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace c3rt::rt
