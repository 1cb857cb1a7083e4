#pragma once
// Times what the sampling strategy does for a place of the end effector: the LCS there, the solve,
// and the objects' cost as the plan is tried.

namespace bench {

/// One candidate and six of a T, and one among four objects, all of them in the model.
void add_candidates();

}  // namespace bench
