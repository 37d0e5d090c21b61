// Reads /proc, whose files have no size until they are read.
#include "bench/machine.h"

#include <thread>

#include "base/error.h"
#include "base/file/file.h"
#include "base/memory/memory.h"

namespace kiln {
namespace {

std::string firstText(const char* path) {
  std::string text(16384, '\0');
  try {
    text.resize(File(path).readSomeAt(0, std::as_writable_bytes(std::span(text))));
  } catch (const Error&) {
    text.clear();
  }
  return text;
}

// Returns the text behind "KEY  :" in the first line that begins with KEY.
std::string valueOf(const std::string& text, const std::string& key) {
  const std::size_t at = text.starts_with(key) ? 0 : text.find("\n" + key);
  const std::size_t colon = at == std::string::npos ? at : text.find(':', at);
  if (colon == std::string::npos) return "";
  const std::size_t begin = text.find_first_not_of(" \t", colon + 1);
  const std::size_t end = text.find('\n', colon);
  return begin == std::string::npos || begin >= end ? "" : text.substr(begin, end - begin);
}

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

Machine thisMachine() {
  Machine out;
  out.processor = valueOf(firstText("/proc/cpuinfo"), "model name");
  if (out.processor.empty()) out.processor = "unknown";
  out.logical_cores = std::thread::hardware_concurrency();
  out.memory_bytes = machineMemoryBytes();
  out.system =
      firstLine(firstText("/proc/sys/kernel/ostype")) + " " + firstLine(firstText("/proc/sys/kernel/osrelease"));
#if defined(__clang__)
  out.compiler = "Clang " __clang_version__;
#else
  out.compiler = "GCC " __VERSION__;
#endif
#ifndef NDEBUG
  out.assertions = true;
#endif
  out.version = KILN_VERSION;
  return out;
}

}  // namespace kiln
