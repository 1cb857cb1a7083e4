#pragma once

namespace c3rt::c3 {

/// The caller's threads, if it has any for the solver: the solver itself starts none.
struct Parallel {
  using Task = void (*)(void* context, int index, int worker) noexcept;

  /// Runs task(context, index, worker) once for every index < count and returns when all have
  /// ended. Calls with the same worker (< workers) do not overlap. Null: the solver loops by
  /// itself.
  void (*run)(void* pool, int count, Task task, void* context) noexcept = nullptr;
  void* pool = nullptr;
  int workers = 1;
};

}  // namespace c3rt::c3
