// The words of a call, which are the options of the command line: rows of job/option.h, found by their names.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "convert/convert.h"
#include "ingest/source_words.h"
#include "job/command/given_flags.h"
#include "python/call.h"

namespace kiln::python {

/// Texts by long flag: {"--azimuth": ["20"]}. Python makes the texts (kiln/_words.py).
using Texts = std::map<std::string, std::vector<std::string>>;

/// throws: Error kUsage for a name that is no flag of a job.
GivenFlags givenFlags(const Texts& texts);

/// A picture's description from Python.
struct JobWords {
  std::string json;  // a job with the objects among the words; `volume` is not part of it. Empty: no objects
  Texts flags;
  std::string function;  // a transfer function as JSON, instead of --tf; empty for none
};
/// Returns the job of a volume, and of more. throws: Error kUsage for wrong words.
RenderJob jobOf(const std::filesystem::path& volume, const JobWords& words, const AddedVolumes& more = {});
/// Returns the function of a text of --tf, or of JSON. throws: Error kUsage.
TransferFunctionChoice functionOf(const std::string& text);

/// The words of a volume file as texts: {"spacing": "1,1,2"}. throws: Error kUsage for unknown words.
SourceWords sourceWords(const std::map<std::string, std::string>& texts);

void bindWords(py::module_& module);

}  // namespace kiln::python
