# Not run (README.md of the folder above): names of packages and variants are unchecked.
import os

from spack.package import *


class Kiln(CMakePackage):
    """A renderer for scalar volumes larger than memory, on CPUs."""

    maintainers = []
    license("Apache-2.0")

    version("0.1.0", url=os.environ.get("KILN_SOURCE", ""), sha256=os.environ.get("KILN_SHA256", ""))

    variant("mpi", default=True, description="Work on many machines")
    variant("hdf5", default=True, description="Read HDF5 files")
    variant("openjpeg", default=True, description="Read slices of JPEG 2000")
    variant("letters", default=False, description="Draw letters over pictures; needs DejaVuSans.ttf on the machine")
    variant("view", default=True, description="View volumes in a browser")
    variant("python", default=False, description="Make the Python package")

    conflicts("%gcc@:11", msg="Kiln is C++20 for GCC 12 and later")
    conflicts("platform=darwin")
    conflicts("platform=windows")

    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("openvdb@10:")
    depends_on("tbb")
    depends_on("boost@1.74:+iostreams")
    depends_on("openexr@3.1:")
    depends_on("imath@3.1:")
    depends_on("glm")
    depends_on("fmt@9:")
    depends_on("nlohmann-json")
    depends_on("libpng")
    depends_on("libtiff@4.5:")
    depends_on("zlib-api")
    depends_on("jpeg")
    depends_on("bzip2")
    depends_on("xz")
    depends_on("expat")
    depends_on("xxhash")
    depends_on("highway@1:")
    depends_on("c-blosc")
    depends_on("lz4")
    depends_on("zstd")
    depends_on("libdeflate")
    depends_on("cli11@2:", type="build")
    depends_on("gdcm@3:")
    depends_on("mpi@3:", when="+mpi")
    depends_on("hdf5@1.10:~mpi", when="+hdf5")
    depends_on("openjpeg@2.3:", when="+openjpeg")
    depends_on("freetype", when="+letters")
    depends_on("py-pybind11@2.10:", when="+python", type="build")
    depends_on("py-numpy", when="+python", type=("build", "run"))
    extends("python", when="+python")

    generator("ninja")

    def cmake_args(self):
        return [
            # OpenVDB's find module lies beside its library.
            self.define("CMAKE_MODULE_PATH", join_path(self.spec["openvdb"].prefix.lib, "cmake", "OpenVDB")),
            self.define("KILN_TESTS", False),
            self.define_from_variant("KILN_MPI", "mpi"),
            self.define_from_variant("KILN_HDF5", "hdf5"),
            self.define_from_variant("KILN_OPENJPEG", "openjpeg"),
            self.define_from_variant("KILN_VIEW", "view"),
            self.define_from_variant("KILN_FREETYPE", "letters"),
            self.define_from_variant("KILN_PYTHON", "python"),
        ]
