#pragma once
// The parts of the extension; module.cpp puts them together.
#include <nanobind/nanobind.h>

namespace c3rt::python {

void bind_lcs(nanobind::module_& module);
void bind_problem(nanobind::module_& module);
void bind_models(nanobind::module_& module);
void bind_recording(nanobind::module_& module);
void bind_emulator(nanobind::module_& module);
void bind_planner(nanobind::module_& module);
void bind_wire_check(nanobind::module_& module);

}  // namespace c3rt::python
