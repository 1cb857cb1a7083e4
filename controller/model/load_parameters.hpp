#pragma once
#include "config/robot.hpp"
#include "controller/model/arm.hpp"

namespace c3rt::model {

/// What the arm's model needs of a robot's description.
ArmDescription load_arm(const config::Robot& robot);

}  // namespace c3rt::model
