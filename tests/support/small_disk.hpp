#pragma once
// A disk that is soon full: a small tmpfs in a mount namespace of this process. Where mounting is
// not allowed it is not there, and the test says so.
#include <filesystem>
#include <string>

#include <sched.h>
#include <stdlib.h>
#include <sys/mount.h>

namespace c3rt::test {

class SmallDisk {
 public:
  explicit SmallDisk(const char* size = "512k") {
    std::string name = (std::filesystem::temp_directory_path() / "c3rt-disk-XXXXXX").string();
    path_ = mkdtemp(name.data());
    // a namespace of our own, so that nobody else sees the mount, and it ends with the process
    static const bool own =
        unshare(CLONE_NEWNS) == 0 && mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
    const std::string options = std::string("size=") + size;
    mounted_ = own && mount("c3rt-test", path_.c_str(), "tmpfs", 0, options.c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount2(path_.c_str(), MNT_DETACH);
    std::error_code error;
    std::filesystem::remove(path_, error);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool mounted() const { return mounted_; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  bool mounted_ = false;
};

}  // namespace c3rt::test
