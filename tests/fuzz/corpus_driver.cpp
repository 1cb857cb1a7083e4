// Runs a fuzz target where there is no libFuzzer: over every file of the corpus, then over
// deterministic mutations of them.
//
//   corpus_driver MUTATIONS FOLDER...        all of it
//   corpus_driver --only INDEX FOLDER...     one input again, printed
#include <algorithm>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <unistd.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

namespace fs = std::filesystem;

// what is running, for the handler of a crash
volatile std::sig_atomic_t current = 0;

void say_which(int signal) {
  char text[80];
  const int length = std::snprintf(text, sizeof text, "input %d ended by signal %d (see --only)\n",
                                   static_cast<int>(current), signal);
  if (length > 0) (void)!write(STDERR_FILENO, text, static_cast<std::size_t>(length));
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

std::vector<std::string> read_corpus(char** first, char** last) {
  std::vector<fs::path> files;
  for (; first != last; ++first) {
    for (const fs::directory_entry& entry : fs::directory_iterator(*first)) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> texts;
  for (const fs::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    texts.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return texts;
}

class Mutator {
 public:
  Mutator(const std::vector<std::string>& corpus, unsigned seed) : corpus_(corpus), random_(seed) {}

  std::string operator()() {
    std::string text = corpus_[below(corpus_.size())];
    const std::size_t steps = 1 + below(4);
    for (std::size_t i = 0; i < steps; ++i) change(text);
    return text;
  }

 private:
  std::size_t below(std::size_t bound) { return bound == 0 ? 0 : random_() % bound; }

  void change(std::string& text) {
    const std::size_t at = below(text.size() + 1), length = below(1 + below(64));
    switch (below(7)) {
      case 0:  // one byte
        if (at < text.size()) text[at] = static_cast<char>(random_());
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(below(text.size() + 1), length));
        break;
      case 3: {  // part of another file
        const std::string& other = corpus_[below(corpus_.size())];
        text.replace(at, length, other.substr(below(other.size() + 1), below(200)));
        break;
      }
      default:  // the most telling: a number becomes another one
        replace_number(text, at);
    }
  }

  void replace_number(std::string& text, std::size_t from) {
    static const std::vector<std::string> kValues{"0",
                                                  "-1",
                                                  "1e308",
                                                  "-1e308",
                                                  "1e-308",
                                                  "1e8",
                                                  "1e-8",
                                                  "1e400",
                                                  "NaN",
                                                  "null",
                                                  "[]",
                                                  "{}",
                                                  "\"x\"",
                                                  "1.5",
                                                  "2",
                                                  "3",
                                                  "false",
                                                  "1000",
                                                  "100000",
                                                  "2147483648",
                                                  "-2147483649",
                                                  ".inf",
                                                  "-.inf",
                                                  "-0.0",
                                                  "~",
                                                  "*a",
                                                  "&a 1",
                                                  "9007199254740993",
                                                  "99999999999999999999",
                                                  "\xff"};
    const std::string digits = "0123456789";
    const std::size_t first = text.find_first_of(digits, from);
    if (first == std::string::npos) return;
    const std::size_t last = std::min(text.find_first_not_of(digits + ".eE+-", first), text.size());
    text.replace(first, last - first, kValues[below(kValues.size())]);
  }

  const std::vector<std::string>& corpus_;
  std::mt19937 random_;
};

bool run(const std::string& text, int index) {
  current = index;
  try {
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    return true;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "input %d (see --only): %s\n", index, error.what());
    return false;
  }
}

}  // namespace

int main(int argc, char** argv) {
  const bool only = argc > 2 && std::string(argv[1]) == "--only";
  if (argc < 3 + (only ? 1 : 0)) {
    std::fprintf(stderr, "usage: %s MUTATIONS FOLDER... | --only INDEX FOLDER...\n", argv[0]);
    return 2;
  }
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) {
    std::signal(signal, &say_which);
  }
  const int number = std::atoi(argv[only ? 2 : 1]);
  const std::vector<std::string> corpus = read_corpus(argv + (only ? 3 : 2), argv + argc);
  if (corpus.empty()) {
    std::fprintf(stderr, "the corpus is empty\n");
    return 2;
  }
  Mutator mutate(corpus, 1);
  const int files = static_cast<int>(corpus.size()), last = only ? number : files + number - 1;
  int failures = 0;
  for (int i = 0; i <= last; ++i) {
    const std::string text = i < files ? corpus[static_cast<std::size_t>(i)] : mutate();
    if (only && i < last) continue;
    if (only) {
      std::fwrite(text.data(), 1, text.size(), stdout);
      std::fflush(stdout);  // it may not end well
    }
    failures += run(text, i) ? 0 : 1;
  }
  std::printf("%d inputs, %d failures\n", only ? 1 : last + 1, failures);
  return failures == 0 ? 0 : 1;
}
