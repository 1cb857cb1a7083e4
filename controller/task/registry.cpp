#include "controller/task/registry.hpp"

#include "kinds.hpp"

namespace c3rt::task {
namespace {

struct Kind {
  const char* name;
  Task (*load)(Source& source);
};

template <typename... Types>
std::vector<Kind> table() {
  return {{Types::kKind, [](Source& source) -> Task { return Types::load(source); }}...};
}

const std::vector<Kind>& all_kinds() {
  static const std::vector<Kind> kinds = table<C3RT_TASK_KINDS>();
  return kinds;
}

}  // namespace

std::vector<std::string> kinds() {
  std::vector<std::string> names;
  for (const Kind& kind : all_kinds()) names.emplace_back(kind.name);
  return names;
}

Task load(Source& source) {
  return all_kinds()[static_cast<std::size_t>(source.choice("kind", kinds()))].load(source);
}

Task load(const Request& request) {
  RequestSource source(request);
  Task task = load(source);
  source.finish();
  return task;
}

}  // namespace c3rt::task
