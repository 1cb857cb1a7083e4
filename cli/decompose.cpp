#include "cli/decompose.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>

#include "cli/paths.hpp"
#include "cli/program.hpp"

namespace c3rt::cli {
namespace fs = std::filesystem;
namespace {

constexpr double kPatience = 600.0;  // [s]

/// A folder that ends with it.
class Scratch {
 public:
  Scratch() {
    std::string name = (fs::temp_directory_path() / "c3rt-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
      throw std::runtime_error("cannot make a folder for coacd: " +
                               std::string(std::strerror(errno)));
    path_ = name;
  }
  ~Scratch() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  fs::path file(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

}  // namespace

std::vector<mesh::Triangles> decompose(const mesh::Triangles& mesh, int most) {
  const Scratch scratch;
  const fs::path in = scratch.file("in.obj"), out = scratch.file("out.obj");
  write_text(in, mesh::to_obj(mesh));
  const ProgramEnd end = run_program({"coacd", "-i", in.string(), "-o", out.string(), "-c",
                                      std::to_string(most), "--seed", "0", "--quiet"},
                                     "", kPatience);
  const std::string expected = "--decompose: expected convex pieces from the program coacd, ";
  if (end.kind == ProgramEnd::Kind::kNotFound) {
    throw UsageError(expected + "which is not in PATH: " + kDecomposerInstalled +
                     "; or save the mesh as separate closed convex parts in one file");
  }
  if (!end.ok()) {
    const std::size_t last = end.output.find_last_not_of(" \n");
    const std::string said = last == std::string::npos ? "" : end.output.substr(0, last + 1);
    throw UsageError(expected + "which " + end.reason +
                     (said.empty() ? "" : ": " + said.substr(said.find_last_of('\n') + 1)));
  }
  try {
    return mesh::components(mesh::parse(read_text(out), out.filename().string()));
  } catch (const mesh::Error& error) {
    throw UsageError(expected + "got a file that is none: " + error.what());
  }
}

}  // namespace c3rt::cli
