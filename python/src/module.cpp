// The extension c3rt._core: what Python sees of the libraries.
#include <exception>

#include "cli/paths.hpp"
#include "cli/recording/mcap.hpp"
#include "config/config_error.hpp"
#include "controller/mjcf/error.hpp"
#include "python/src/bind.hpp"

NB_MODULE(_core, module) {
  module.doc() = "The libraries of c3rt; import c3rt instead.";
  nanobind::register_exception_translator([](const std::exception_ptr& thrown, void* /*unused*/) {
    try {
      std::rethrow_exception(thrown);
    } catch (const c3rt::config::ConfigError& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    } catch (const c3rt::mjcf::Error& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    } catch (const c3rt::mcap::Error& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    } catch (const c3rt::cli::UsageError& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    }
  });
  c3rt::python::bind_lcs(module);
  c3rt::python::bind_problem(module);
  c3rt::python::bind_models(module);
  c3rt::python::bind_recording(module);
  c3rt::python::bind_emulator(module);
  c3rt::python::bind_planner(module);
  c3rt::python::bind_wire_check(module);
}
