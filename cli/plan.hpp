#pragma once
// `c3rt plan`: the planner alone, driven by somebody else's simulator over its standard streams.
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace c3rt::cli {

/// Reads a scene from each line (JSON) and answers each with a line that says where the end
/// effector should be one period later: docs/clients.md. No bus, no clock: time is what the lines
/// say, so the same lines give the same answers.
/// @return an exit status: kDone when the lines end
/// @throws UsageError naming the line and what was expected
int plan(const std::string& scenario, const std::vector<std::string>& overrides, std::istream& in,
         std::ostream& out);

}  // namespace c3rt::cli
