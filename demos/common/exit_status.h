// Exit statuses of the tools and demos, part of their documented behaviour.
#ifndef QC_DEMOS_COMMON_EXIT_STATUS_H
#define QC_DEMOS_COMMON_EXIT_STATUS_H

typedef enum qcExitStatus
{
    qc_exitDone = 0,
    qc_exitFailed = 1, ///< output could not be written, out of memory, or a check of the results failed
    qc_exitUsage = 2,
    qc_exitBadInput = 3, ///< a mesh or model can't be read
    qc_exitDevice = 4,   ///< the GL device does not work here
    qc_exitNoPeers = 5,  ///< no peer library was found when this was built
    qc_exitSignal = 128  ///< plus the number of the signal
} qcExitStatus;

#endif
