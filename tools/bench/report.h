// A report's directory: the page, the numbers for programs, the suite, and the pictures by themselves.
#pragma once

#include <filesystem>
#include <vector>

#include "base/file.h"
#include "bench/measurements.h"

namespace kiln {

/// throws: Error kExists where `directory` holds something that is no part of a report, so that nothing of the user's
/// is replaced; kUsage where it is no directory. A directory that is not there is fine.
void requireReportDirectory(const std::filesystem::path& directory);

/// Writes report.html, report.json, measurements.csv, suite.json and pictures/. Each file is whole or not there; the
/// page is the last. An earlier report is replaced. throws: Error kNoSpace, kIo.
void writeReport(const Measurements& m, const std::filesystem::path& directory, FileSystem& disk = FileSystem::real());

/// The files of a report beside its pictures and stores.
std::vector<std::filesystem::path> reportFiles(const std::filesystem::path& directory);
/// The file among these whose text is the suite's.
inline std::filesystem::path suiteFileOf(const std::filesystem::path& directory) { return directory / "suite.json"; }

/// Where a report keeps the stores that it converted.
inline std::filesystem::path storesOf(const std::filesystem::path& directory) { return directory / "stores"; }

}  // namespace kiln
