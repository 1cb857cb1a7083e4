// Tags through cameras that are no renderer's, as those of a real table would be.
#include "vision/tag_tracker.hpp"

#include <memory>
#include <string>

#include <catch2/catch.hpp>

#include "tests/vision/printed_tags.hpp"

using namespace c3rt;
using namespace c3rt::vision;
using namespace c3rt::vision::test;
using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

const TagParameters kTags{30, 320, {0.2, 1.0}, {0.1, 1.0, 0.2, 8.0, 3, 0.5}};

scene::Tag tag(int id, double x, double y) {
  return {id, 0.032, {x, y, 0.02}, Eigen::Matrix3d::Identity()};
}

std::vector<scene::Tag> top_of_t() {
  return {tag(0, -0.06, 0.03), tag(1, -0.02, 0.03), tag(2, 0.02, 0.03), tag(3, 0.06, 0.03),
          tag(4, 0, -0.01),    tag(5, 0, -0.05),    tag(6, 0, -0.09)};
}

Isometry3d pose(double x, double y, double yaw) {
  Isometry3d X = Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix();
  X.translation() << x, y, 0.0;
  return X;
}

/// The T's own tags and one more.
PrintedTags printed_with(const scene::Tag& more, const Isometry3d& X_WB) {
  PrintedTags all = printed(top_of_t(), X_WB);
  all.push_back(printed({more}, X_WB)[0]);
  return all;
}

Prediction expect(const Isometry3d& X_WB) {
  return {X_WB.translation(), true, Eigen::Quaterniond(X_WB.linear())};
}

struct Table {
  explicit Table(std::vector<TaggedObject> objects = {{"t", top_of_t()}}) {
    for (const Vector3d& p :
         {Vector3d(1.2, 0, 0.7), Vector3d(0.45, 0.75, 0.75), Vector3d(0.45, -0.75, 0.75)}) {
      cameras.push_back(std::make_unique<PrintedCamera>(table_camera(p)));
    }
    std::vector<Camera*> all;
    for (const auto& camera : cameras) all.push_back(camera.get());
    tracker = std::make_unique<TagTracker>(kTags, 1, std::move(objects), all);
  }
  void show(const PrintedTags& tags) {
    for (const auto& camera : cameras) camera->tags = tags;
  }
  const std::vector<TagSighting>& look(const std::vector<Prediction>& predictions) {
    return tracker->observe(++exposure_ns, predictions);
  }
  std::vector<std::unique_ptr<PrintedCamera>> cameras;
  std::unique_ptr<TagTracker> tracker;
  std::int64_t exposure_ns = 0;
};

double off(const JointFit& fit, const Isometry3d& X_WB) {
  return (fit.p_WB - X_WB.translation()).norm();
}
double turned(const JointFit& fit, const Isometry3d& X_WB) {
  return fit.q_WB.angularDistance(Eigen::Quaterniond(X_WB.linear()));
}

}  // namespace

TEST_CASE("tags: a printed picture is read where it was drawn, whatever its turn") {
  // as one reads it: the corners begin at the lower left
  PrintedCamera camera(table_camera({1.2, 0, 0.7}));
  TagDetector detector;
  for (const int id : {0, 7, 586}) {
    for (const double yaw : {0.0, 1.1, 3.0}) {
      camera.tags = printed({tag(id, 0, 0)}, pose(0.6, 0.02, yaw));
      cv::Mat image, grey;
      const Roi roi{400, 300, 400, 400, 1};
      REQUIRE(camera.grab(1, roi, image));
      cv::cvtColor(image, grey, cv::COLOR_RGB2GRAY);
      const std::vector<SeenTag> seen = detector.detect(grey);
      CAPTURE(id, yaw);
      REQUIRE(seen.size() == 1);
      CHECK(seen[0].id == id);
      const auto corners = tag_corners(camera.tags[0]);
      for (std::size_t k = 0; k < 4; ++k) {
        const Eigen::Vector2d at =
            project(camera.model(), camera.model().X_WC.inverse() * corners[k]);
        CHECK((to_full(roi, seen[0].corners[k].x(), seen[0].corners[k].y()) - at).norm() < 0.3);
      }
    }
  }
  CHECK_THROWS_WITH(tag_picture(587), Catch::Contains("0 to 586"));
  CHECK_THROWS(detector.detect(cv::Mat(10, 10, CV_8UC3)));
}

TEST_CASE("tags: an object is found anywhere on the table, then tracked") {
  Table table;
  Isometry3d X_WB = pose(0.45, 0.2, 2.0);
  table.show(printed(top_of_t(), X_WB));
  const TagSighting first = table.look({{{0.55, 0, 0}, true}})[0];
  REQUIRE(first.fit.found);
  CHECK(first.cameras_used == 3);
  CHECK(off(first.fit, X_WB) < 2e-4);
  CHECK(turned(first.fit, X_WB) < 2e-3);
  CHECK(first.fit.views_used == 21);

  const Isometry3d expected = X_WB;
  X_WB = pose(0.455, 0.195, 2.05);
  table.show(printed(top_of_t(), X_WB));
  CHECK(off(table.look({expect(expected)})[0].fit, X_WB) < 2e-4);

  // carried elsewhere
  X_WB = pose(0.65, -0.15, -1.0);
  table.show(printed(top_of_t(), X_WB));
  const TagSighting& again = table.look({expect(expected)})[0];
  REQUIRE(again.fit.found);
  CHECK(off(again.fit, X_WB) < 2e-4);
  CHECK(table.tracker->take_notices().empty());
}

TEST_CASE("tags: one camera and two tags of it are enough, nothing is not") {
  Table table;
  const Isometry3d X_WB = pose(0.55, 0.0, 0.4);
  table.cameras[0]->tags = printed({top_of_t()[0], top_of_t()[5]}, X_WB);
  table.cameras[2]->blind = true;
  const TagSighting one = table.look({expect(X_WB)})[0];
  REQUIRE(one.fit.found);
  CHECK(one.cameras_used == 1);
  CHECK(off(one.fit, X_WB) < 3e-3);
  CHECK(one.views[0].used);
  CHECK_FALSE(one.views[1].used);
  CHECK(one.views[1].frame);
  CHECK_FALSE(one.views[2].frame);

  table.show({});
  CHECK_FALSE(table.look({expect(X_WB)})[0].fit.found);
}

TEST_CASE("tags: an unknown id is counted, told once, and moves nothing") {
  Table table;
  const Isometry3d X_WB = pose(0.55, 0.05, 0.0);
  table.show(printed_with(tag(41, 0.05, -0.05), X_WB));
  for (int k = 0; k < 3; ++k) CHECK(off(table.look({expect(X_WB)})[0].fit, X_WB) < 2e-4);
  CHECK(table.tracker->counts().unknown == 9);
  const auto notices = table.tracker->take_notices();
  REQUIRE(notices.size() == 1);
  CHECK(notices[0] == "tag 41 is on no object of the scenario: ignored");
}

TEST_CASE("tags: an id that is in an image twice is not used there") {
  Table table;
  const Isometry3d X_WB = pose(0.55, 0.05, 0.0);
  table.show(printed_with(tag(3, 0.06, -0.05), X_WB));
  const TagSighting& seen = table.look({expect(X_WB)})[0];
  CHECK(off(seen.fit, X_WB) < 2e-4);
  CHECK(seen.fit.views_used == 18);
  CHECK(table.tracker->counts().twice == 6);
  CHECK(table.tracker->take_notices().at(0) == "tag 3 is in one image twice: neither is used");
}

TEST_CASE("tags: one of another size, or elsewhere than its file says, is left out and told") {
  Table table;
  const Isometry3d X_WB = pose(0.55, 0.05, 0.3);
  std::vector<scene::Tag> wrong = top_of_t();
  wrong[2].size = 0.026;
  wrong[6].p_BT.x() += 0.005;
  table.show(printed(wrong, X_WB));
  for (int k = 0; k < 25; ++k) {
    const TagSighting& seen = table.look({expect(X_WB)})[0];
    CHECK(seen.fit.views_used == 15);
    CHECK(off(seen.fit, X_WB) < 2e-4);
  }
  CHECK(table.tracker->counts().outliers == 25 * 6);
  const auto notices = table.tracker->take_notices();
  REQUIRE(notices.size() == 2);
  CHECK_THAT(
      notices[0],
      Catch::Contains("tag 2 of \"t\" is never where its file puts it: its edge is 26.") ||
          Catch::Contains("tag 2 of \"t\" is never where its file puts it: its edge is 25."));
  CHECK_THAT(notices[0], Catch::Contains("where the file says 32.0 mm: not used"));
  CHECK(notices[1] == "tag 6 of \"t\" is never where its file puts it: not used");
}

TEST_CASE("tags: two objects are told apart by their ids, which must differ") {
  std::vector<scene::Tag> other = top_of_t();
  for (scene::Tag& t : other) t.id += 100;
  const std::vector<TaggedObject> both{{"t", top_of_t()}, {"u", other}};
  Table table(both);
  const Isometry3d first = pose(0.5, 0.12, 0.3), second = pose(0.55, -0.1, 2.0);
  PrintedTags all = printed(top_of_t(), first);
  for (const scene::Tag& t : printed(other, second)) all.push_back(t);
  table.show(all);
  const auto& seen = table.look({{{0.55, 0, 0}, true}, {{0.55, 0, 0}, true}});
  CHECK(off(seen[0].fit, first) < 2e-4);
  CHECK(off(seen[1].fit, second) < 2e-4);
  CHECK(table.tracker->counts().unknown == 0);

  const std::vector<TaggedObject> twins{{"t", top_of_t()}, {"u", top_of_t()}}, bare{{"bare", {}}};
  CHECK_THROWS_WITH(Table(twins), Catch::Contains("id 0 is on \"t\" and on \"u\""));
  CHECK_THROWS_WITH(Table(bare), Catch::Contains("\"bare\" has none"));
}
