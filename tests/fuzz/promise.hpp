#pragma once
// What a fuzz target says of its subject: a promise that is broken ends the program.
#include <cstdio>
#include <cstdlib>

inline void require(bool holds, const char* promise) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", promise);
  std::abort();
}
