#include "base/refusal.h"

#include <new>
#include <string_view>
#include <system_error>

namespace kiln {

Refusal refusalOf(const std::exception& error) noexcept {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return Refusal::kMemory;
  if (const auto* const of_system = dynamic_cast<const std::system_error*>(&error)) {
    if (of_system->code() == std::errc::resource_unavailable_try_again) return Refusal::kThreads;
    if (of_system->code() == std::errc::not_enough_memory) return Refusal::kMemory;
    return Refusal::kNone;
  }
  const std::string_view text = error.what();
  if (text.find("std::bad_alloc") != std::string_view::npos) return Refusal::kMemory;
  // TBB: "pthread_create has failed: Resource temporarily unavailable".
  return text.find("pthread_create") != std::string_view::npos ? Refusal::kThreads : Refusal::kNone;
}

void rethrowRefusal() {
  try {
    throw;
  } catch (const std::exception& error) {
    if (refusalOf(error) != Refusal::kNone) throw;
  } catch (...) {
  }
}

}  // namespace kiln
