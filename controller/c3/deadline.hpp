#pragma once

namespace c3rt::c3 {

/// The caller's question "is it time to stop?", asked between the steps of Algorithm 1 and inside
/// branch and bound. Null: never. The solver itself reads no clock.
struct Deadline {
  bool (*reached)(void* context) noexcept = nullptr;
  void* context = nullptr;

  bool struck() const noexcept { return reached != nullptr && reached(context); }
};

}  // namespace c3rt::c3
