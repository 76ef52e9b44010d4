// Where Bullet was not found.
#include "replay/box_replay.h"

std::unique_ptr<qcBoxReplay> qcMakeBroadphaseReplay(uint32_t /*scalarSize*/)
{
    return nullptr;
}
