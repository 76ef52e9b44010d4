# Sourced by tests/run.sh --sanitize: what the sanitizers read at run time. A finding ends the program with a failure.
# shellcheck shell=sh disable=SC2154 # root is set by the caller.
ASAN_OPTIONS=strict_string_checks=1:detect_stack_use_after_return=1
UBSAN_OPTIONS=print_stacktrace=1
LSAN_OPTIONS=suppressions=$root/tests/presets/leak.supp:print_suppressions=0
TSAN_OPTIONS=suppressions=$root/tests/presets/thread.supp:print_suppressions=0:second_deadlock_stack=1:die_after_fork=0
MSAN_OPTIONS=print_stats=0
export ASAN_OPTIONS UBSAN_OPTIONS LSAN_OPTIONS TSAN_OPTIONS MSAN_OPTIONS
