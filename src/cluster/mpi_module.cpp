// Loads the module that holds the message-passing library: a process that mpirun has not started loads nothing of it,
// starts as fast as ever, and Kiln's library needs no MPI to be linked.
#include <dlfcn.h>

#include "base/error.h"
#include "cluster/ranks.h"

namespace kiln {

std::unique_ptr<Ranks> mpiRanks() {
#ifdef KILN_MPI_MODULE
  // Found beside the program, as its own libraries are. Never closed: MPI's exit handlers are in it.
  void* const module = ::dlopen(KILN_MPI_MODULE, RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr)
    throw Error(ErrorCode::kUnsupported, KILN_MPI_MODULE, "",
                std::string("cannot be loaded, so that ranks cannot work together: ") + ::dlerror());
  using Make = Ranks* (*)();
  const auto make = reinterpret_cast<Make>(::dlsym(module, "kilnMakeMpiRanks"));
  if (make == nullptr)
    throw Error(ErrorCode::kUnsupported, KILN_MPI_MODULE, "", "is not of this version of Kiln; install it anew");
  return std::unique_ptr<Ranks>(make());
#else
  throw Error(ErrorCode::kUnsupported,
              "this kiln was built without MPI, and each process that mpirun starts would do all of the work; build it "
              "with MPI (Debian: libopenmpi-dev), or run it without mpirun");
#endif
}

}  // namespace kiln
