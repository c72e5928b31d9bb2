// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <exception>
#include <string>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "eval/output/plain_text.h"
#include "eval/records/names.h"
#include "features/extractor.h"
#include "pose/absolute_orientation.h"
#include "pose/solver.h"
#include "python/module/bindings.h"
#include "python/module/long_call.h"
#include "scenes/files/assets.h"
#include "scenes/files/input_error.h"
#include "scenes/files/toml_table.h"

namespace sightline {
namespace {

namespace py = pybind11;

// Lives as long as the interpreter, like the module that holds it.
PyObject* input_error_class = nullptr;

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const InputError& error) {
    PyErr_SetString(input_error_class, in_one_line(error.what()).c_str());
  } catch (const Interrupted& error) {
    PyErr_SetString(PyExc_KeyboardInterrupt, in_one_line(error.what()).c_str());
  }
}

void bind_errors(py::module_& module) {
  input_error_class = PyErr_NewExceptionWithDoc(
      "sightline.InputError",
      "Something that was given cannot be used: a file, a key, an option, a name, an array.\n\n"
      "Its text is the one line that the program prints.",
      PyExc_ValueError, nullptr);
  module.add_object("InputError", py::reinterpret_borrow<py::object>(input_error_class));
  py::register_exception_translator(translate);
}

template <typename Catalogue>
py::dict summaries_of(const Catalogue& catalogue) {
  py::dict out;
  for (const auto& entry : catalogue) out[py::str(entry.name)] = py::str(entry.summary);
  return out;
}

py::dict text_of_files(const std::vector<std::string>& names,
                       std::filesystem::path (*find)(const std::string&), const char* key) {
  py::dict out;
  for (const std::string& name : names) {
    out[py::str(name)] = TomlTable::read_file(find(name)).text(key, "");
  }
  return out;
}

void bind_lists(py::module_& module) {
  module.def("solvers", [] { return summaries_of(pose_solvers()); });
  module.def("methods", [] { return summaries_of(orientation_methods()); });
  module.def("extractors", [] { return summaries_of(feature_extractors()); });
  module.def("targets",
             [] { return text_of_files(target_names(), find_target_file, "description"); });
  module.def("studies", [] { return text_of_files(study_names(), find_study_file, "question"); });
  module.def("outcomes", [] {
    return std::vector<std::string>(kEstimateOutcomes.begin(), kEstimateOutcomes.end());
  });
  module.def("use_assets", &use_assets);
}

}  // namespace
}  // namespace sightline

PYBIND11_MODULE(_sightline, module) {
  module.attr("version") = SIGHTLINE_VERSION;
  sightline::prepare_forks();
  sightline::bind_errors(module);
  sightline::bind_lists(module);
  sightline::bind_pose(module);
  sightline::bind_study(module);
  sightline::bind_frames(module);
}
