#pragma once
// `c3rt solve`: one call of C3 on a problem file.
#include <string>

namespace c3rt::cli {

/// @param out path of the result file, "" or "-" for standard output
/// @return an exit status: kDone for an answer (also a truncated one), kCriterionFailed for none,
///         kUndecided where the search for (15) ended before it knew whether there is one
int solve(const std::string& path, const std::string& out);

}  // namespace c3rt::cli
