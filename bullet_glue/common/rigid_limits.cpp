// The certificates of rigid meshes, by the dispatcher of their world.
#include "common/rigid_limits.h"

#include <map>
#include <mutex>

namespace
{
struct Registry
{
    std::mutex mutex;
    std::map<const btDispatcher*, qcRigidLimits*> limits;
};

Registry& GetRegistry()
{
    // Never destroyed: a qcMeshContact of static storage ends after what is made in its life.
    static Registry& registry = *new Registry;
    return registry;
}
} // namespace

void qcAddRigidLimits(const btDispatcher* dispatcher, qcRigidLimits* limits)
{
    Registry& registry = GetRegistry();
    std::lock_guard<std::mutex> lock(registry.mutex);
    registry.limits[dispatcher] = limits;
}

void qcRemoveRigidLimits(const qcRigidLimits* limits)
{
    Registry& registry = GetRegistry();
    std::lock_guard<std::mutex> lock(registry.mutex);
    for (auto entry = registry.limits.begin(); entry != registry.limits.end();)
        entry = entry->second == limits ? registry.limits.erase(entry) : std::next(entry);
}

qcRigidLimits* qcFindRigidLimits(const btDispatcher* dispatcher)
{
    Registry& registry = GetRegistry();
    std::lock_guard<std::mutex> lock(registry.mutex);
    auto found = registry.limits.find(dispatcher);
    return found != registry.limits.end() ? found->second : nullptr;
}
