#include "controller/task/registry.hpp"

#include "controller/task/circle.hpp"
#include "controller/task/line.hpp"
#include "controller/task/path.hpp"
#include "controller/task/pose.hpp"

namespace c3rt::task {
namespace {

struct Kind {
  const char* name;
  Task (*load)(Source& source);
};

template <typename T>
Kind kind() {
  return {T::kKind, [](Source& source) -> Task { return T::load(source); }};
}

const Kind kKinds[] = {kind<Circle>(), kind<Path>(), kind<Line>(), kind<Pose>()};

}  // namespace

std::vector<std::string> kinds() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

Task load(Source& source) { return kKinds[source.choice("kind", kinds())].load(source); }

Task load(const Request& request) {
  RequestSource source(request);
  Task task = load(source);
  source.finish();
  return task;
}

}  // namespace c3rt::task
