#include "cli/campaign/files.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include <catch2/catch.hpp>

#include "config/tree.hpp"
#include "tests/cli/folder.hpp"

namespace {

using c3rt::cli::Folder;
using c3rt::cli::campaign::hash_of_files;

/// Of a scenario whose object is `object/t.xml`, which has a mesh in a folder of its own.
struct Case {
  Case() {
    std::filesystem::create_directories(folder.path() / "object" / "meshes");
    write("object/t.xml", R"(<mujoco><compiler meshdir="meshes"/><mesh file="t.obj"/></mujoco>)");
    write("object/meshes/t.obj", "v 0 0 0\n");
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder.path() / name) << text;
  }
  std::string hash(const std::string& text) const {
    return hash_of_files(c3rt::config::parse_yaml(text, (folder.path() / "a.yaml").string()));
  }

  Folder folder;
  const std::string by_key = "plant: {objects: [{mjcf: object/t.xml, mass_scale: 2}]}";
};

}  // namespace

TEST_CASE("files: a changed model is another run, the same text again is the same run") {
  const Case of;
  const std::string before = of.hash(of.by_key);
  CHECK(of.hash(of.by_key) == before);
  of.write("object/t.xml", R"(<mujoco><compiler meshdir="meshes"/><mesh file='t.obj' /></mujoco>)");
  CHECK(of.hash(of.by_key) != before);
}

TEST_CASE("files: so is a changed mesh that the model names, in a list, too") {
  const Case of;
  const std::string in_list = "planner: {model: {objects: [object/t.xml, object/t.xml]}}";
  const std::string before = of.hash(of.by_key), of_list = of.hash(in_list);
  of.write("object/meshes/t.obj", "v 0 0 1\n");
  CHECK(of.hash(of.by_key) != before);
  CHECK(of.hash(in_list) != of_list);
}

TEST_CASE("files: what no value names does not count, and a model that includes itself ends") {
  const Case of;
  const std::string before = of.hash(of.by_key);
  of.write("object/other.xml", "<mujoco/>");
  CHECK(of.hash(of.by_key) == before);
  of.write("object/other.xml", R"(<mujoco><include file="other.xml"/></mujoco>)");
  CHECK(of.hash("a: object/other.xml") != of.hash("a: not_there.xml"));
}
