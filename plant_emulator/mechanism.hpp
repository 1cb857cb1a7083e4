#pragma once
// A mechanism of any MuJoCo model (MJCF) with its contacts, as the plant of an experiment. No
// network, no clock.
#include <memory>
#include <string>

#include <Eigen/Core>

namespace c3rt::plant {

/// x = [q; v] of scene/mechanism.hpp, u = the motors' inputs.
class Mechanism {
 public:
  /// At home, at rest. @param step of the integration [s]
  /// @throws mjcf::Error for what mjcf::read_mechanism refuses
  Mechanism(const std::string& mjcf, double step);
  ~Mechanism();
  Mechanism(Mechanism&&) noexcept;
  Mechanism& operator=(Mechanism&&) noexcept;

  /// @throws std::invalid_argument if x is not finite or of another size
  void reset(const Eigen::VectorXd& x);
  /// RT: no heap, no lock, no throw.
  void step(const Eigen::Ref<const Eigen::VectorXd>& u) noexcept;
  /// @param x (n_x) is overwritten
  void state(Eigen::Ref<Eigen::VectorXd> x) const noexcept;

 private:
  struct Simulation;
  std::unique_ptr<Simulation> simulation_;
};

}  // namespace c3rt::plant
