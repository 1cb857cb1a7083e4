#include "controller/base/hash.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using c3rt::base::Hash;

TEST_CASE("hash: FNV-1a's published values") {
  const auto hash_of = [](const char* text) {
    Hash hash;
    hash.add(text);
    return hash.text();
  };
  CHECK(hash_of("") == "fnv1a64:cbf29ce484222325");
  CHECK(hash_of("a") == "fnv1a64:af63dc4c8601ec8c");
  CHECK(hash_of("foobar") == "fnv1a64:85944171f73967e8");
}

TEST_CASE("hash: a number counts by its bytes, so that the last digit tells two apart") {
  Hash a, b, c;
  a.add(0.1);
  b.add(0.1);
  c.add(std::nextafter(0.1, 1.0));
  CHECK(a.value() == b.value());
  CHECK(a.value() != c.value());
}
