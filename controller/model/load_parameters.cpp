#include "controller/model/load_parameters.hpp"

namespace c3rt::model {

ArmDescription load_arm(const config::Robot& robot) {
  const config::Robot::EndEffector& tool = robot.end_effector;
  return {urdf_path(robot.urdf),
          robot.flange,
          {tool.mass, tool.center_of_mass, tool.inertia_xx, tool.inertia_zz, tool.sphere_center}};
}

}  // namespace c3rt::model
