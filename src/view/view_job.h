// Jobs that a browser edits: JSON without files. The session adds the files; a job that names a file is refused.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "job/render_job.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Checks what a session can show of a job, before its volumes are opened. throws: Error kUsage.
void requireViewable(const RenderJob& job);

/// Returns the session's job for the browser. Transfer functions from files become objects. `manifests`: one for each
/// volume. throws: as readTransferFunction.
nlohmann::ordered_json jobForBrowser(const RenderJob& session, const std::vector<const Manifest*>& manifests);

/// Returns the job that a browser sent, drawn at `size`, with volumes, speed, encodings and series of the session's.
/// throws: Error kUsage for a key that names a file, is the session's own or unknown, or has a wrong value.
RenderJob jobOfBrowser(const nlohmann::json& job, const ImageSize& size, const RenderJob& session);

/// Returns the text of a file with the browser's job, for `kiln render`. `session` names the volumes; names inside the
/// file's folder become relative. `kept` are keys for the file, as keptKeys returns. throws: as jobOfBrowser.
std::string savedJobText(const nlohmann::json& job, const ImageSize& size, const RenderJob& session,
                         const std::string& kept, const std::filesystem::path& file);

/// Returns the keys of a job's file that no browser edits and saving keeps, as JSON: files that the job writes, their
/// encoding, frames, and options of the machine. Names of files become absolute. throws: as readJob.
std::string keptKeys(const std::filesystem::path& job_file);

}  // namespace kiln
