# Sourced by tests/run.sh --sanitize: what the sanitizers read at run time. A finding ends the program with a failure.
# shellcheck shell=sh disable=SC2154 # root is set by the caller.
# Some tests watch resident memory, to which memory belongs that was freed and is watched for a while.
ASAN_OPTIONS=strict_string_checks=1:detect_stack_use_after_return=1:quarantine_size_mb=4:thread_local_quarantine_size_kb=64
UBSAN_OPTIONS=print_stacktrace=1
LSAN_OPTIONS=suppressions=$root/tests/presets/leak.supp:print_suppressions=0
TSAN_OPTIONS=suppressions=$root/tests/presets/thread.supp:print_suppressions=0:second_deadlock_stack=1:die_after_fork=0
MSAN_OPTIONS=print_stats=0
# Tests take up to thirty times as long.
CK_TIMEOUT_MULTIPLIER=20
export ASAN_OPTIONS UBSAN_OPTIONS LSAN_OPTIONS TSAN_OPTIONS MSAN_OPTIONS CK_TIMEOUT_MULTIPLIER

# qc_hide_gl FOLDER: no GL device opens, since the loader finds empty files in FOLDER before the drivers. For the memory
# sanitizer, for which drivers are not built.
qc_hide_gl()
{
    mkdir -p "$1"
    for library in libEGL.so.1 libOSMesa.so.8 libOSMesa.so.6 libOSMesa.so; do
        : >"$1/$library"
    done
    QC_TEST_DEVICES=
    LD_LIBRARY_PATH=$1${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
    export QC_TEST_DEVICES LD_LIBRARY_PATH
}
