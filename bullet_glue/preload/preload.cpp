// The functions of btDbvtBroadphase over a qcBroadphase. Preloaded, they replace those in the distribution's
// libBulletCollision, for programs that were built without this library:
//
//     LD_PRELOAD=DIR/lib/libqc-preload.so QC_PRELOAD_STATISTICS=1 PROGRAM
//
// Proof that this is safe: plugin/docs/proofs/preload.md.
#include "quickcullide/bullet_broadphase.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

#include <dlfcn.h>
#include <link.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace
{
/// Calls of this process; queries may run on several threads.
struct Statistics
{
    std::atomic<long long> broadphases{0}, proxies{0}, boxes{0}, searches{0}, pairs{0}, rays{0}, boxTests{0};

    ~Statistics()
    {
        const char* setting = std::getenv("QC_PRELOAD_STATISTICS");
        if (setting == nullptr || std::strcmp(setting, "1") != 0)
            return;
        std::fprintf(stderr,
                     "qc-preload: %lld broadphases, %lld proxies, %lld boxes set, %lld searches for pairs that found "
                     "%lld, %lld rays, %lld box tests\n",
                     broadphases.load(), proxies.load(), boxes.load(), searches.load(), pairs.load(), rays.load(),
                     boxTests.load());
    }
};

Statistics s_statistics;

int AppendName(dl_phdr_info* info, size_t, void* names)
{
    static_cast<std::vector<std::string>*>(names)->push_back(info->dlpi_name);
    return 0;
}

/// The file that defines a symbol, in the search order that begins with `file`; an empty name if there is none.
std::string DefinerSeenFrom(const std::string& file, const char* symbol)
{
    std::string definer;
    void* handle = dlopen(file.c_str(), RTLD_LAZY | RTLD_NOLOAD);
    if (handle == nullptr)
        return definer;
    Dl_info info;
    void* address = dlsym(handle, symbol);
    if (address != nullptr && dladdr(address, &info) != 0 && info.dli_fbase != nullptr)
        definer = info.dli_fname;
    dlclose(handle);
    return definer;
}

/// Ends the process, which has two Bullets, with the cure if one of them is of the precision that this file is not for.
[[noreturn]] void EndWithTwo(const std::string& first, const std::string& second, const char* self)
{
    const bool isSingle = sizeof(btScalar) == sizeof(float);
    // The last letter is that of the parameter, a btScalar.
    const char* symbol = isSingle ? "_ZNK16btCollisionShape27getContactBreakingThresholdEd"
                                  : "_ZNK16btCollisionShape27getContactBreakingThresholdEf";
    std::string other = DefinerSeenFrom(first, symbol);
    if (other.empty())
        other = DefinerSeenFrom(second, symbol);
    if (!other.empty())
        std::fprintf(stderr, "qc-preload: %s is Bullet in %s precision; preload %s instead of %s.\n", other.c_str(),
                     isSingle ? "double" : "single", isSingle ? "libqc-preload-double.so" : "libqc-preload.so", self);
    else
        std::fprintf(stderr, "qc-preload: both %s and %s have a btDbvtBroadphase, and %s was built for one of them.\n",
                     first.c_str(), second.c_str(), self);
    std::fputs("The process ends here, since their objects differ.\n", stderr);
    std::_Exit(EXIT_FAILURE);
}

/// Ends the process if it has a second Bullet: libraries of other precisions and versions, and copies inside of other
/// libraries, have the same symbols for different objects. The Bullet that this file was built with is always loaded.
/// Called at start and for each new broadphase, since libraries may have been opened in between.
__attribute__((constructor)) void CheckLibraries()
{
    std::vector<std::string> files;
    dl_iterate_phdr(AppendName, &files);
    Dl_info self;
    if (dladdr(reinterpret_cast<void*>(CheckLibraries), &self) == 0)
        return;
    std::string bullet;
    for (const std::string& file : files)
    {
        // The program has no name here, and finds this file's symbols first.
        if (file.empty() || file == self.dli_fname)
            continue;
        const std::string definer = DefinerSeenFrom(file, "_ZN16btDbvtBroadphaseC1EP22btOverlappingPairCache");
        if (definer.empty() || definer == self.dli_fname || definer == bullet)
            continue;
        if (bullet.empty())
        {
            bullet = definer;
            continue;
        }
        EndWithTwo(bullet, definer, self.dli_fname);
    }
}

/// Stored where btDbvtBroadphase has the head of its list of resting proxies.
qcBroadphase& BroadphaseOf(const btDbvtBroadphase* interface)
{
    return *reinterpret_cast<qcBroadphase*>(interface->m_stageRoots[btDbvtBroadphase::STAGECOUNT]);
}
} // namespace

btDbvtBroadphase::btDbvtBroadphase(btOverlappingPairCache* paircache)
{
    CheckLibraries();
    qcBroadphase* broadphase = new qcBroadphase(paircache);
    for (btDbvtProxy*& root : m_stageRoots)
        root = nullptr;
    m_stageRoots[STAGECOUNT] = reinterpret_cast<btDbvtProxy*>(broadphase);
    m_paircache = broadphase->getOverlappingPairCache();
    m_releasepaircache = paircache == nullptr;
    // Bullet's initial values, for programs that read them.
    m_prediction = 0;
    m_stageCurrent = 0;
    m_fupdates = 1;
    m_dupdates = 0;
    m_cupdates = 10;
    m_newpairs = 1;
    m_fixedleft = 0;
    m_updates_call = m_updates_done = 0;
    m_updates_ratio = 0;
    m_pid = m_cid = m_gid = 0;
    m_deferedcollide = false;
    m_needcleanup = true;
    s_statistics.broadphases++;
}

btDbvtBroadphase::~btDbvtBroadphase()
{
    delete &BroadphaseOf(this);
}

btBroadphaseProxy* btDbvtBroadphase::createProxy(const btVector3& aabbMin, const btVector3& aabbMax, int shapeType,
                                                 void* userPtr, int collisionFilterGroup, int collisionFilterMask,
                                                 btDispatcher* dispatcher)
{
    s_statistics.proxies++;
    return BroadphaseOf(this).createProxy(aabbMin, aabbMax, shapeType, userPtr, collisionFilterGroup,
                                          collisionFilterMask, dispatcher);
}

void btDbvtBroadphase::destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher)
{
    BroadphaseOf(this).destroyProxy(proxy, dispatcher);
}

void btDbvtBroadphase::setAabb(btBroadphaseProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax,
                               btDispatcher* dispatcher)
{
    s_statistics.boxes++;
    BroadphaseOf(this).setAabb(proxy, aabbMin, aabbMax, dispatcher);
}

void btDbvtBroadphase::setAabbForceUpdate(btBroadphaseProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax,
                                          btDispatcher* dispatcher)
{
    s_statistics.boxes++;
    BroadphaseOf(this).setAabb(proxy, aabbMin, aabbMax, dispatcher);
}

void btDbvtBroadphase::getAabb(btBroadphaseProxy* proxy, btVector3& aabbMin, btVector3& aabbMax) const
{
    BroadphaseOf(this).getAabb(proxy, aabbMin, aabbMax);
}

void btDbvtBroadphase::rayTest(const btVector3& rayFrom, const btVector3& rayTo, btBroadphaseRayCallback& rayCallback,
                               const btVector3& aabbMin, const btVector3& aabbMax)
{
    s_statistics.rays++;
    BroadphaseOf(this).rayTest(rayFrom, rayTo, rayCallback, aabbMin, aabbMax);
}

void btDbvtBroadphase::aabbTest(const btVector3& aabbMin, const btVector3& aabbMax, btBroadphaseAabbCallback& callback)
{
    s_statistics.boxTests++;
    BroadphaseOf(this).aabbTest(aabbMin, aabbMax, callback);
}

/// Bullet splits calculateOverlappingPairs into this function and performDeferredRemoval. All work is done here.
void btDbvtBroadphase::collide(btDispatcher* dispatcher)
{
    BroadphaseOf(this).calculateOverlappingPairs(dispatcher);
    s_statistics.searches++;
    s_statistics.pairs += m_paircache->getNumOverlappingPairs();
}

void btDbvtBroadphase::performDeferredRemoval(btDispatcher*)
{
}

void btDbvtBroadphase::calculateOverlappingPairs(btDispatcher* dispatcher)
{
    collide(dispatcher);
    performDeferredRemoval(dispatcher);
}

/// Bullet optimizes its trees here. There are none.
void btDbvtBroadphase::optimize()
{
}

btOverlappingPairCache* btDbvtBroadphase::getOverlappingPairCache()
{
    return m_paircache;
}

const btOverlappingPairCache* btDbvtBroadphase::getOverlappingPairCache() const
{
    return m_paircache;
}

void btDbvtBroadphase::getBroadphaseAabb(btVector3& aabbMin, btVector3& aabbMax) const
{
    BroadphaseOf(this).getBroadphaseAabb(aabbMin, aabbMax);
}

void btDbvtBroadphase::resetPool(btDispatcher* dispatcher)
{
    BroadphaseOf(this).resetPool(dispatcher);
}

void btDbvtBroadphase::printStats()
{
    BroadphaseOf(this).printStats();
}

/// Empty in distributed builds of Bullet, too.
void btDbvtBroadphase::benchmark(btBroadphaseInterface*)
{
}
