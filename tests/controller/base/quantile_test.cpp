#include "controller/base/quantile.hpp"

#include <vector>

#include <catch2/catch.hpp>

using namespace c3rt::base;

TEST_CASE("linear quantiles lie between the two values around them") {
  const std::vector<double> values{1.0, 2.0, 4.0, 8.0, 16.0};
  CHECK(quantile_linear(values, 0.0) == 1.0);
  CHECK(quantile_linear(values, 1.0) == 16.0);
  CHECK(quantile_linear(values, 0.5) == 4.0);
  CHECK(quantile_linear(values, 0.25) == 2.0);
  CHECK(quantile_linear(values, 0.95) == Approx(8.0 + 0.8 * 8.0));
  CHECK(quantile_linear({1.0, 3.0}, 0.5) == 2.0);
  CHECK(quantile_linear({7.0}, 0.95) == 7.0);
}

TEST_CASE("quantiles by nearest rank are samples: the smallest that covers the share") {
  for (int count = 1; count <= 200; ++count) {
    std::vector<double> sorted;
    for (int i = 1; i <= count; ++i) sorted.push_back(i * i);
    for (const double share : {0.5, 0.95, 0.99, 0.999, 1.0}) {
      // by its definition, one after the other
      std::size_t i = 0;
      while (static_cast<double>(i + 1) < share * static_cast<double>(count)) ++i;
      CHECK(quantile_nearest(sorted, share) == sorted[i]);
    }
  }
  CHECK(quantile_nearest({3.0, 4.0}, 0.0) == 3.0);
}
