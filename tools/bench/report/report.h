// The directory of a report: the page, the numbers for programs, the suite, and the pictures as files.
#pragma once

#include <filesystem>
#include <vector>

#include "base/file/file.h"
#include "bench/measurements.h"

namespace kiln {

/// Protects the user's files. throws: Error kExists if `directory` contains anything that is no part of a report;
/// kUsage if it is not a directory. A missing directory is accepted.
void requireReportDirectory(const std::filesystem::path& directory);

/// Writes report.html, report.json, measurements.csv, suite.json and pictures/, replacing an earlier report. Each file
/// is written whole or not at all; the page comes last. throws: Error kNoSpace, kIo.
void writeReport(const Measurements& m, const std::filesystem::path& directory, FileSystem& disk = FileSystem::real());

/// Returns the files of a report, without pictures and stores.
std::vector<std::filesystem::path> reportFiles(const std::filesystem::path& directory);
/// Returns the file of a report with the suite's text.
inline std::filesystem::path suiteFileOf(const std::filesystem::path& directory) { return directory / "suite.json"; }

/// Returns the folder for stores converted by the suite.
inline std::filesystem::path storesOf(const std::filesystem::path& directory) { return directory / "stores"; }

}  // namespace kiln
