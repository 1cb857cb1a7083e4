#include "cli/ros.hpp"

#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/paths.hpp"

namespace c3rt::cli {
namespace {

constexpr unsigned long kLastDomain = 230;

/// As ROS 2's own programs have it.
std::uint32_t domain_of_environment() {
  const char* text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  char* end = nullptr;
  const unsigned long domain = std::strtoul(text, &end, 10);
  if (*end != '\0' || domain > kLastDomain)
    throw UsageError(fmt::format("ROS_DOMAIN_ID: expected 0 to {}, got {}", kLastDomain, text));
  return static_cast<std::uint32_t>(domain);
}

}  // namespace

int ros(const Seat& seat, const RosSettings& settings) {
  const std::uint32_t domain = settings.domain ? *settings.domain : domain_of_environment();
  if (domain == seat.domain) {
    throw UsageError(fmt::format(
        "domain {} is c3rt's own, whose DDS profile is not ROS 2's: start c3rt on another one, "
        "c3rt up circle_slow --domain 42, and name it here with --domain",
        seat.domain));
  }
  become_python(seat, "c3rt.ros", "dds", {"cyclonedds"}, shown_scene(seat, settings.shown),
                {"--ros-domain", std::to_string(domain), "--frame", settings.frame, "--rate",
                 fmt::format("{}", settings.rate_hz)});
}

}  // namespace c3rt::cli
