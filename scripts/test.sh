#!/usr/bin/env bash
# Builds and runs the tests: test.sh [--nightly] [--only dev|asan|tsan].
# Most of them under the address and undefined-behaviour sanitizers, but for those that draw many pictures or large ones;
# those that threads meet in under the thread sanitizer; and last, in the build nearest to what users run, those that a
# sanitizer is too slow for or may hide: these pictures, known answers, memory, Kiln's use as a library. With --nightly
# or --only dev that build runs everything. Several ranks work together in that build only: Open MPI leaves memory behind
# at its end and orders its threads in ways that the sanitizers do not see, and what ranks do alone, the other tests do.
# The first stage that fails ends the script with its exit code; what is built is not built again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage() { echo "usage: scripts/test.sh [--nightly] [--only dev|asan|tsan]" >&2; exit 2; }

presets=(asan tsan dev)
nightly=OFF
whole_dev=OFF
while [ $# -gt 0 ]; do
  case $1 in
    --nightly) nightly=ON; whole_dev=ON; shift ;;
    --only)
      case ${2-} in dev | asan | tsan) presets=("$2") ;; *) usage ;; esac
      whole_dev=ON
      shift 2 ;;
    *) usage ;;
  esac
done

scripts/install_packages.sh build mpi test
scripts/check_includes.sh

configure=(-DKILN_TESTS=ON "-DKILN_NIGHTLY=$nightly")
if command -v ccache >/dev/null; then configure+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi

# What draws many pictures or large ones takes minutes under a sanitizer, and others go the same ways; what starts the
# program many times to draw small ones shows more of the loader than of Kiln there.
large='LatticeWeights|Extinction|PictureQuality|VolumeMixPicture|UniformMediumHasNoSeams|Panorama|Turn|Zoom'
large+='|DeepImages.*(OfParts|AreTheFlat)|PartialImages.OfOctants|Checkpoint.(GoesOn|ChangesNo|TakesNo)|SeveralVolumesAreDeep'
large+='|Samples.AreMeans|TraceCli.SaysWhat|NeedsNoSliceInMemory|ReferenceRenderer|BenchReport|Bench\.'
large+='|(Scene|Views|Volumes|Sequence|Labels|Progress)Cli|CliKilled|Cli.(AnInterrupt|ADryRunForetellsTheRender)'

# In these, one thread does what is looked at, or the others show the same of threads, and faster.
of_one_thread='Phantom|RealExactness|HiddenBricks|VisitingOrder|VisibilityMethods|ImageFile|Samples|Crop|Paging|Pyramid'
of_one_thread+='|Skipping|(PictureEquality|MixedLevels).*/\([12],|SharedConversion|Stereo\.|DeepImages|PartialImages|SubBricks'
of_one_thread+='|Labels.AreDrawn|InstructionSets|VolumeMixEquality.(ATransp|TooLittle|HoldsWhere)|FrameProgressOf.(PartsAre|ACheckpoint)|SampleWindow|SoftBlocks'

export ASAN_OPTIONS=detect_leaks=1
export UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS="suppressions=$PWD/tests/support/tsan.supp"

for preset in "${presets[@]}"; do
  echo "== $preset, after $SECONDS s"
  # Threads meet in the unit and property tests.
  chosen=()
  targets=()
  # The largest of the real files take minutes, too; they are for --nightly and --only dev. How much memory a picture
  # takes, a sanitizer cannot say.
  if [ "$preset" = asan ] && [ "$nightly" = OFF ]; then
    chosen=(-LE known_answer -E "NOT_BUILT|RealExport.*(smoke|sphere)|RealData.*vhm_head|MemoryBudget|Ranks|$large")
    targets=(--target kiln_tool kiln_unit_tests kiln_property_tests kiln_format_tests kiln_fault_tests kiln_cli_tests)
  fi
  if [ "$preset" = tsan ]; then
    chosen=(-L 'unit|property' -E "$of_one_thread|$large")
    targets=(--target kiln_unit_tests kiln_property_tests)
  fi
  if [ "$preset" = dev ] && [ "$whole_dev" = OFF ]; then
    chosen=(-R "^known_answer|^consumer|MemoryBudget|Ranks|$large")
    targets=(--target kiln_tool kiln_unit_tests kiln_property_tests kiln_format_tests kiln_known_answer_tests kiln_cli_tests)
  fi
  cmake --preset "$preset" "${configure[@]}"
  cmake --build --preset "$preset" -j "$(nproc)" "${targets[@]}"
  ctest --preset "$preset" -j 2 --no-tests=error "${chosen[@]}"
done
