#include "cli/campaign/files.hpp"

#include <filesystem>
#include <regex>
#include <set>
#include <utility>
#include <vector>

#include "cli/paths.hpp"
#include "config/directory.hpp"
#include "controller/base/hash.hpp"

namespace c3rt::cli::campaign {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLongestName = 1000;

class Files {
 public:
  void visit(const config::Tree& tree) {
    for (const config::Tree& item : tree.list) visit(item);
    for (const config::Entry& entry : tree.map) visit(entry.value);
    if (!tree.is_scalar() || tree.scalar.empty() || tree.scalar.size() > kLongestName) return;
    const fs::path own = tree.place.file ? fs::path(*tree.place.file).parent_path() : fs::path();
    // as a scenario's section looks for them
    (void)(add(own / tree.scalar) || add(config::directory() / "scenarios" / tree.scalar));
  }

  std::string hash() const { return hash_.text(); }

 private:
  /// @return whether it is there
  bool add(const fs::path& file) {
    std::error_code error;
    if (!fs::is_regular_file(file, error)) return false;
    if (!known_.insert(fs::weakly_canonical(file, error)).second) return true;
    const std::string text = read_text(file);
    hash_.add(text.size());
    hash_.add(text);
    if (file.extension() == ".xml") add_named(file.parent_path(), text);
    return true;
  }

  /// What a MuJoCo model names: by file="…", from its folder or those that <compiler> says.
  void add_named(const fs::path& folder, const std::string& text) {
    std::vector<fs::path> folders{folder};
    static const std::regex folder_word(R"re((?:mesh|asset)dir\s*=\s*["']([^"']*)["'])re");
    static const std::regex file_word(R"re(\bfile\s*=\s*["']([^"']*)["'])re");
    const std::sregex_iterator end;
    for (std::sregex_iterator at(text.begin(), text.end(), folder_word); at != end; ++at)
      folders.push_back(folder / (*at)[1].str());
    for (std::sregex_iterator at(text.begin(), text.end(), file_word); at != end; ++at)
      for (const fs::path& from : folders) add(from / (*at)[1].str());
  }

  base::Hash hash_;
  std::set<fs::path> known_;
};

}  // namespace

std::string hash_of_files(const config::Tree& scenario) {
  Files files;
  files.visit(scenario);
  return files.hash();
}

}  // namespace c3rt::cli::campaign
