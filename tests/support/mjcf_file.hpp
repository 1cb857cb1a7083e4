#pragma once
// A MuJoCo model in a file that ends with the test.
#include <fstream>
#include <string>

#include "tests/cli/folder.hpp"

namespace c3rt::test {

class MjcfFile {
 public:
  /// @param inside of the element mujoco
  explicit MjcfFile(const std::string& inside) {
    std::ofstream(path_) << "<mujoco>" << inside << "</mujoco>";
  }
  std::string path() const { return path_; }

 private:
  cli::Folder folder_;
  std::string path_ = (folder_.path() / "thing.xml").string();
};

}  // namespace c3rt::test
