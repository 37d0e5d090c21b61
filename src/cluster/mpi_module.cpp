// Loads the MPI module only in a process that mpirun started.
#include "base/error.h"
#include "base/module.h"
#include "cluster/ranks.h"

namespace kiln {

std::unique_ptr<Ranks> mpiRanks([[maybe_unused]] const CallLimit& limit) {
#ifdef KILN_MPI_MODULE
  using Make = Ranks* (*)(const CallLimit&);
  const auto make =
      reinterpret_cast<Make>(functionOfModule(KILN_MPI_MODULE, "kilnMakeMpiRanks", "ranks cannot work together"));
  return std::unique_ptr<Ranks>(make(limit));
#else
  throw Error(ErrorCode::kUnsupported,
              "this kiln was built without MPI, and each process that mpirun starts would do all of the work; build it "
              "with MPI (Debian: libopenmpi-dev), or run it without mpirun");
#endif
}

}  // namespace kiln
