#include "idl/client/estimator.hpp"

#include <optional>
#include <stdexcept>

#include "controller/base/time.hpp"
#include "controller/base/words.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/client/part.hpp"
#include "idl/client/settings.hpp"
#include "idl/text.hpp"
#include "idl/validate.hpp"

namespace c3rt::client {

wire::ObjectEstimate estimate_sample(const Estimate& estimate, std::int64_t exposure_ns) {
  constexpr std::size_t kLongestName = sizeof(wire::ObjectEstimate::name) - 1;
  if (estimate.index < 0 || estimate.index >= c3rt_v2_MAX_OBJECTS) {
    throw std::invalid_argument(
        base::words("index: expected 0 to %d, got %d", c3rt_v2_MAX_OBJECTS - 1, estimate.index));
  }
  if (estimate.name.size() > kLongestName) {
    throw std::invalid_argument("name: expected at most " + std::to_string(kLongestName) +
                                " bytes, got \"" + estimate.name + "\"");
  }
  wire::ObjectEstimate sample{};
  sample.object_index = estimate.index;
  wire::set_text(sample.name, estimate.name);
  sample.exposure_ns = exposure_ns;
  sample.valid = estimate.valid;
  sample.sensors_used = estimate.valid ? 1 : 0;
  fill(sample.p_measured_m, estimate.p);
  fill(sample.p_WB_m, estimate.p);
  fill_unit(sample.q_measured, estimate.q);
  fill_unit(sample.q_WB, estimate.q);
  fill(sample.v_WB_m_per_s, estimate.v);
  fill(sample.omega_rad_per_s, estimate.omega);
  // the readers would refuse it
  sample.header.time_ns = exposure_ns;
  if (const wire::Refusal refused = wire::validate(sample))
    throw std::invalid_argument(to_text(refused));
  return sample;
}

/// One run().
class Estimator::Seeing final : public Process::Part {
 public:
  Seeing(Estimator& estimator, const Place& place)
      : Part(c3rt_v2_PROCESS_VISION, place,
             {estimator.settings_.rate, estimator.settings_.of_exposures}),
        estimator_(estimator) {}

 private:
  void step(std::int64_t now_ns) override;
  void see(std::int64_t exposure_ns);
  wire::Answer obey(c3rt_v2_RequestVerb) override { return {false, "vision knows only shutdown"}; }

  Estimator& estimator_;
  wire::Reader<wire::Scene> scenes_{bus(), kQueue};
  wire::Writer<wire::ObjectEstimate> estimates_{bus()};
  std::atomic<std::uint64_t>& exposures_ = endpoint().status().counter("exposures");
  std::optional<wire::Scene> truth_;
};

void Estimator::Seeing::step(std::int64_t now_ns) {
  serve(now_ns);
  wire::Scene scene{};
  while (scenes_.take_next_effective(now_ns, scene)) {
    truth_ = scene;
    if (estimator_.settings_.of_exposures && scene.exposure) see(scene.header.time_ns);
  }
  if (!estimator_.settings_.of_exposures) see(now_ns);
}

void Estimator::Seeing::see(std::int64_t exposure_ns) {
  if (!began()) say(c3rt_v2_SERVICE_RUNNING, "sees");
  begin();
  ++exposures_;
  const std::int64_t begin_ns = rt::now_ns();
  const std::vector<Estimate> seen =
      estimator_.estimate(base::seconds(exposure_ns), truth_ ? &*truth_ : nullptr);
  endpoint().status().compute().add(base::seconds(rt::now_ns() - begin_ns));
  for (const Estimate& estimate : seen) {
    wire::ObjectEstimate sample = estimate_sample(estimate, exposure_ns);
    estimates_.write(sample, lockstep()
                                 ? exposure_ns + base::nanoseconds(estimator_.settings_.latency)
                                 : rt::now_ns());
  }
}

Estimator::Estimator(const EstimatorSettings& settings)
    : Process(c3rt_v2_PROCESS_VISION), settings_(settings) {
  require_within("rate", settings.rate, 1.0, 1000.0);
  require_within("latency", settings.latency, 0.0, 1.0);
}

// not inline: the vtable is the package's
Estimator::~Estimator() = default;

std::unique_ptr<Process::Part> Estimator::take_part(const Place& place) {
  return std::make_unique<Seeing>(*this, place);
}

}  // namespace c3rt::client
