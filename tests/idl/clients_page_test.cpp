// docs/clients.md says what a client must know; here it is compared with what is so.
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include <catch2/catch.hpp>

#include "idl/discovery.hpp"
#include "idl/topics.hpp"

namespace {

using namespace c3rt;

std::string read(const std::string& path) {
  std::ifstream file(std::string(C3RT_SOURCE_DIRECTORY) + "/" + path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string row(const wire::Topic& topic) {
  return std::string("| ") + topic.name + " | " + topic.descriptor->m_typename + " | " +
         wire::offered_qos(topic) + " | " + wire::requested_qos(topic) + " |\n";
}

}  // namespace

TEST_CASE("clients page: every topic's row has its type and the QoS of our writers and readers") {
  const std::string page = read("docs/clients.md");
  for (const wire::Topic& topic : wire::table::kTopics)
    CHECK_THAT(page, Catch::Contains(row(topic)));
}

TEST_CASE("clients page: the programs on it are those that are installed") {
  const std::string page = read("docs/clients.md");
  for (const char* program : {"docs/clients/client.py", "docs/clients/client.cpp",
                              "docs/clients/reader.py", "docs/clients/reader.cpp"}) {
    std::istringstream lines(read(program));
    std::string listing;
    for (std::string line; std::getline(lines, line);)
      listing += (line.empty() ? "" : "    " + line) + "\n";
    REQUIRE(listing.size() > 100);
    CHECK_THAT(page, Catch::Contains(listing));
  }
}
