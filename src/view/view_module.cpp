#include "base/error.h"
#include "base/module.h"
#include "view/view_server.h"

namespace kiln {

std::unique_ptr<ViewServer> makeViewServer([[maybe_unused]] ViewService& service,
                                           [[maybe_unused]] const ViewServerOptions& options) {
#ifdef KILN_VIEW_MODULE
  using Make = ViewServer* (*)(ViewService&, const ViewServerOptions&);
  const auto make =
      reinterpret_cast<Make>(functionOfModule(KILN_VIEW_MODULE, "kilnMakeViewServer", "nothing can be viewed"));
  return std::unique_ptr<ViewServer>(make(service, options));
#else
  throw Error(ErrorCode::kUnsupported,
              "this kiln was built without the viewer; build it with Boost.Beast (Debian: libboost-iostreams-dev)");
#endif
}

}  // namespace kiln
