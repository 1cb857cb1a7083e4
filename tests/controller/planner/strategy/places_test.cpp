#include "controller/planner/strategy/places.hpp"

#include <catch2/catch.hpp>

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector3d;

namespace {

SamplingParameters parameters() {
  SamplingParameters p;
  p.better = 1.6;
  p.margin = 0.02;
  p.valid_moved = 0.004;
  p.valid_turned = 0.04;
  return p;
}

Worth worth(double gain) { return {true, 1.0 - gain, 1.0}; }

}  // namespace

TEST_CASE("places: the one with the most gain is the best, where it is another one") {
  Places places(parameters());
  places.look(0, {});
  places.add({Vector3d(0.1, 0, 0), worth(0.3)});
  places.add({Vector3d(0.2, 0, 0), worth(0.5)});
  places.add({Vector3d(0.3, 0, 0), worth(0.4)});
  places.add({Vector3d(0.4, 0, 0), worth(-0.1)});  // moves the body the wrong way
  places.add({Vector3d(0.5, 0, 0), {}});           // has no plan
  CHECK(places.count() == 3);
  CHECK(places.best(Vector3d::Zero(), 0.015)->p_WE.x() == 0.2);
  CHECK(places.best({0.21, 0, 0}, 0.015)->p_WE.x() == 0.3);
  CHECK(Places(parameters()).best(Vector3d::Zero(), 0.0) == nullptr);
}

TEST_CASE("places: they count until the body has moved or turned") {
  Places places(parameters());
  scene::Body body;
  places.look(0, body);
  places.add({Vector3d(0.1, 0, 0), worth(0.3)});
  body.p_WB.x() = 0.0039;
  places.look(0, body);
  CHECK(places.count() == 1);
  body.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(0.039, Vector3d::UnitZ()));
  places.look(0, body);
  CHECK(places.count() == 1);
  body.p_WB.x() = 0.0041;
  places.look(0, body);
  CHECK(places.count() == 0);
  places.add({Vector3d(0.1, 0, 0), worth(0.3)});
  body.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(0.08, Vector3d::UnitZ()));
  places.look(0, body);
  CHECK(places.count() == 0);
}

TEST_CASE("places: one that failed is forgotten with its neighbours, until the body has moved") {
  Places places(parameters());
  scene::Body body;
  places.look(0, body);
  places.add({Vector3d(0.1, 0, 0), worth(0.5)});
  places.add({Vector3d(0.2, 0, 0), worth(0.3)});
  places.fail(0, {0.105, 0, 0});
  places.add({Vector3d(0.11, 0, 0), worth(0.6)});
  CHECK(places.best(Vector3d::Zero(), 0.0)->p_WE.x() == 0.2);
  body.p_WB.x() = 0.01;
  places.look(0, body);
  places.add({Vector3d(0.11, 0, 0), worth(0.6)});
  CHECK(places.best(Vector3d::Zero(), 0.0)->p_WE.x() == 0.11);
}

TEST_CASE("places: a body that moves takes only its own along") {
  Places places(parameters());
  scene::Body body, other;
  places.look(0, body);
  places.look(1, other);
  places.add({Vector3d(0.1, 0, 0), worth(0.5), 0});
  places.add({Vector3d(0.2, 0, 0), worth(0.3), 1});
  places.fail(1, {0.3, 0, 0});
  body.p_WB.x() = 0.01;
  places.look(0, body);
  places.look(1, other);
  CHECK(places.count() == 1);
  CHECK(places.best(Vector3d::Zero(), 0.0)->body == 1);
  CHECK(places.best_of(0, Vector3d::Zero(), 0.0) == nullptr);
  places.add({Vector3d(0.3, 0, 0), worth(0.9), 1});  // failed, and that body lies where it did
  places.add({Vector3d(0.3, 0, 0), worth(0.8), 0});
  CHECK(places.best(Vector3d::Zero(), 0.0)->body == 0);
  CHECK(places.best_of(1, Vector3d::Zero(), 0.0)->p_WE.x() == 0.2);
  places.forget(1);
  CHECK(places.best_of(1, Vector3d::Zero(), 0.0) == nullptr);
  CHECK(places.count() == 1);
}

TEST_CASE("places: of many the best are kept") {
  Places places(parameters());
  places.look(0, {});
  for (int i = 0; i < 500; ++i)
    places.add({Vector3d(0.01 * i, 0, 0), worth(0.001 * ((i * 37) % 500) + 1e-6)});
  CHECK(places.count() <= 64);
  CHECK(places.best(Vector3d(-1, 0, 0), 0.0)->worth.gain() == Approx(0.499).margin(1e-5));
}

TEST_CASE("places: another is worth the way if it gains enough more, of itself and of the whole") {
  const SamplingParameters p = parameters();
  CHECK(worth_leaving(p, worth(0.2), worth(0.35)));
  CHECK_FALSE(worth_leaving(p, worth(0.2), worth(0.33)));
  CHECK_FALSE(worth_leaving(p, worth(0.0), worth(0.019)));
  CHECK(worth_leaving(p, worth(-0.5), worth(0.021)));
  CHECK(worth_leaving(p, {}, worth(0.021)));
  CHECK_FALSE(worth_leaving(p, worth(-0.5), {}));
}

TEST_CASE("headway: what is left has to fall by its part in time, again and again") {
  Headway headway(0.1, 1.0);
  headway.begin(0.0, 1.0);
  CHECK(headway.made(0.9, 0.95));
  CHECK(headway.made(1.0, 0.89));  // a new start
  CHECK(headway.made(2.0, 0.81));
  CHECK_FALSE(headway.made(2.1, 0.81));
  CHECK(headway.made(2.2, 0.80));
}
