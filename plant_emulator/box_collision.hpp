#pragma once
// Contacts of two boxes that MuJoCo 2.2 finds where there are none.

namespace c3rt::plant {

/// MuJoCo's routine for two boxes takes boxes that stand upright and only just touch, one time in
/// a hundred where their axes differ in the last digits, for boxes that overlap by a whole box:
/// they fly apart at 2 m/s. From now on, in every scene of this process, contacts that are deeper
/// than the boxes overlap are found anew by MuJoCo's routine for convex meshes. All others keep
/// their bits.
void check_box_collisions() noexcept;

}  // namespace c3rt::plant
