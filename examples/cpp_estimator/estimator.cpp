// An estimator of one's own in C++: the simulation's truth, a millimetre wrong, through an
// alpha-beta filter, as object/estimate (docs/clients.md). Run with c3rt run circle_slow --without
// vision.
#include "idl/client/estimator.hpp"

#include <map>
#include <random>
#include <vector>

namespace {

using namespace c3rt::client;

constexpr double kNoise = 0.001;                                // along each axis [m]
constexpr double kPositionWeight = 0.4, kVelocityWeight = 0.1;  // of a new measurement
constexpr double kRate = 80.0;                                  // of the exposures [Hz]

/// Position and velocity, corrected by what a measurement is off from where they lead.
struct Tracked {
  Vector p, v{};

  void take(const Vector& measured) {
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double ahead = p[i] + v[i] / kRate, off = measured[i] - ahead;
      p[i] = ahead + kPositionWeight * off;
      v[i] += kVelocityWeight * kRate * off;
    }
  }
};

/// Sees every object of the scene at each exposure.
class Noisy : public Estimator {
 public:
  Noisy() : Estimator({kRate}) {}

  std::vector<Estimate> estimate(double, const c3rt::wire::Scene* truth) override {
    std::vector<Estimate> seen;
    for (int i = 0; i < truth->object_count; ++i) {
      const auto& body = truth->objects[i];
      Vector measured{};
      for (std::size_t k = 0; k < measured.size(); ++k)
        measured[k] = body.p_WB_m[k] + noise_(random_);
      Tracked& known = tracked_.insert({i, Tracked{measured}}).first->second;
      known.take(measured);
      Estimate estimate{i, known.p, {}, known.v};
      for (std::size_t k = 0; k < 4; ++k) estimate.q[k] = body.q_WB[k];
      for (std::size_t k = 0; k < 3; ++k) estimate.omega[k] = body.omega_rad_per_s[k];
      seen.push_back(estimate);
    }
    return seen;
  }

 private:
  std::mt19937_64 random_{1};
  std::normal_distribution<double> noise_{0.0, kNoise};
  std::map<int, Tracked> tracked_;
};

}  // namespace

int main(int argc, char** argv) { return Noisy().main(argc, argv); }
