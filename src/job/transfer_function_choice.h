// The transfer functions that a user may name, and their values for a volume.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "scene/transfer/transfer_function.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Returns the choice that a text states by itself, a preset or points (functionOfPoints); nothing for other texts.
/// throws: Error kUsage without an option's name.
std::optional<TransferFunctionChoice> writtenChoice(const std::string& text);

/// Returns the file without #NAME.
std::filesystem::path fileOf(const std::filesystem::path& file_and_name);

/// Reads the `transferFunction` object of a job, or ParaView's colour maps; which, the content says. A map of
/// ParaView's whose colours run from 0 to 1 is stretched over the volume's range of values. A map without opacity has
/// the range and the opacity of the presets that are colour maps. throws: Error naming file, key, what was found and
/// what was expected: kFormat, kUsage, kUnsupported (a logarithmic scale), kNotFound, kIo.
TransferFunction readTransferFunction(const std::filesystem::path& file_and_name, const Manifest& manifest);

/// Returns the function of a file's text. `path` and `name`, of one map of several, are for errors and the choice.
/// throws: as readTransferFunction.
TransferFunction transferFunctionOfText(const std::string& text, const Manifest& manifest,
                                        const std::filesystem::path& path, const std::string& name = {});

/// The function for this volume. With a window, its first point lies at the window's begin and its last at the end. The
/// unit may be 0, the volume's mean spacing. throws: what `presetFor` and `readTransferFunction` throw.
TransferFunction functionFor(const TransferFunctionChoice& choice, const std::optional<Window>& window,
                             const Manifest& manifest);
/// As functionFor, its unit of length filled in.
TransferFunction resolve(const TransferFunctionChoice& choice, const std::optional<Window>& window,
                         const Manifest& manifest);

}  // namespace kiln
