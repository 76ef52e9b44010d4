// qc-through-double: `qc-bench through` with Bullet in double precision, which can't be in one program with qc-bench's.
#include "bench/bench.h"

#include <argp.h>

int main(int argumentCount, char** arguments)
{
    argp_err_exit_status = qc_exitUsage;
    return (int)qcBench_RunThrough(argumentCount, arguments);
}
