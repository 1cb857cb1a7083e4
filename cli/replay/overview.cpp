#include "cli/replay/overview.hpp"

#include <algorithm>
#include <limits>
#include <type_traits>

#include "cli/paths.hpp"
#include "cli/progress.hpp"
#include "cli/recording/in_order.hpp"
#include "idl/process.hpp"

namespace c3rt::cli::replay {
namespace {

class Looking final : public Listener {
 public:
  explicit Looking(Overview& overview) : overview_(overview) {}
#define C3RT_TOPIC(Type, ...) \
  void hear(const wire::Type& sample) override { look(sample); }
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  bool has_enough() const override { return wire::StopFlag::requested(); }
  bool any() const { return any_; }

 private:
  template <typename T>
  void look(const T& sample) {
    if constexpr (keeps_time(wire::topic<T>())) see(sample.header);
    if constexpr (std::is_same_v<T, wire::RobotState>) {
      if (overview_.first_state == 0) overview_.first_state = sample.header.seq;
    }
    if constexpr (wire::topic<T>().trait == wire::Trait::kAnswered)
      overview_.asked.push_back({overview_.end_ns, sample});
    if constexpr (std::is_same_v<T, wire::ServiceReply>)
      overview_.answered_ns[sample.request_id] = sample.header.time_ns;
  }

  void see(const wire::Header& header) {
    progress_.update("looks over the recording");
    if (!any_) {
      overview_.begin_ns = overview_.end_ns = header.time_ns;
      overview_.session = header.session_id;
    }
    any_ = true;
    overview_.begin_ns = std::min(overview_.begin_ns, header.time_ns);
    overview_.end_ns = std::max(overview_.end_ns, header.time_ns);
    if (header.session_id != overview_.session) ++overview_.of_other_sessions;
  }

  Overview& overview_;
  Progress progress_{"replay"};
  bool any_ = false;
};

}  // namespace

std::uint64_t Asked::request_id() const {
  return std::visit([](const auto& s) { return s.request_id; }, sample);
}

wire::Process Asked::process() const {
  return std::visit([](const auto& s) { return wire::asked_process(s); }, sample);
}

Overview look_over(const std::filesystem::path& file) {
  Overview overview;
  bool any = false;
  {
    Looking looking(overview);
    overview.contents = play(file, looking);
    any = looking.any();
  }
  if (!any && !wire::StopFlag::requested())
    throw UsageError(file.string() + " has no sample of robot, objects or planner");
  return overview;
}

}  // namespace c3rt::cli::replay
