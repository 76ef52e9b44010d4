// Shared by the modules of peer libraries: boxes of triangles, and lists of pairs that several threads fill.
#ifndef QC_DEMOS_BENCH_PEERS_COMMON_H
#define QC_DEMOS_BENCH_PEERS_COMMON_H

#include "bench/peers/triangles.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <exception>
#include <limits>
#include <mutex>
#include <vector>

/// A closed box of floats around a triangle.
struct qcPeerBox
{
    float lower[3], upper[3];
};

inline bool qcPeerBox_Overlap(const qcPeerBox& a, const qcPeerBox& b)
{
    return a.lower[0] <= b.upper[0] && b.lower[0] <= a.upper[0] && a.lower[1] <= b.upper[1] &&
           b.lower[1] <= a.upper[1] && a.lower[2] <= b.upper[2] && b.lower[2] <= a.upper[2];
}

/// Rounded outwards where the positions are doubles.
inline qcPeerBox qcPeerBox_Find(const qcPeerBody& body, const qcPeerPose& pose, uint32_t triangle)
{
    const uint32_t* t = body.indices + 3 * std::size_t(triangle);
    qcPeerBox box;
    if (pose.floats != nullptr)
    {
        const float *a = pose.floats + 3 * std::size_t(t[0]), *b = pose.floats + 3 * std::size_t(t[1]),
                    *c = pose.floats + 3 * std::size_t(t[2]);
        for (int i = 0; i < 3; ++i)
        {
            box.lower[i] = std::min(std::min(a[i], b[i]), c[i]);
            box.upper[i] = std::max(std::max(a[i], b[i]), c[i]);
        }
        return box;
    }
    // At most half an ulp is lost by rounding; the box is enlarged by twice that.
    const float ulp = std::numeric_limits<float>::epsilon(), least = std::numeric_limits<float>::min();
    const double *a = pose.doubles + 3 * std::size_t(t[0]), *b = pose.doubles + 3 * std::size_t(t[1]),
                 *c = pose.doubles + 3 * std::size_t(t[2]);
    for (int i = 0; i < 3; ++i)
    {
        float lower = float(std::min(std::min(a[i], b[i]), c[i]));
        float upper = float(std::max(std::max(a[i], b[i]), c[i]));
        box.lower[i] = lower - (std::fabs(lower) * ulp + least);
        box.upper[i] = upper + (std::fabs(upper) * ulp + least);
    }
    return box;
}

/// Lists of pairs, one for each thread that finds some in a step.
class qcPeerLanes
{
  public:
    /// Before each step.
    void Clear()
    {
        static unsigned long long s_steps = 0;
        m_step = ++s_steps;
        m_used = 0;
    }

    /// The calling thread's list.
    std::vector<qcPeerPair>& Mine()
    {
        // Called for every candidate: it costs one access to the thread's own memory.
        static thread_local unsigned long long s_step = 0;
        static thread_local std::vector<qcPeerPair>* s_lane = nullptr;
        if (s_step != m_step)
        {
            s_lane = Take();
            s_step = m_step;
        }
        return *s_lane;
    }

    /// After the step: all pairs in one list.
    qcPeerAnswer Join()
    {
        if (m_used == 0)
            return {nullptr, 0};
        for (std::size_t i = 1; i < m_used; ++i)
            m_lanes[0].insert(m_lanes[0].end(), m_lanes[i].begin(), m_lanes[i].end());
        return {m_lanes[0].data(), m_lanes[0].size()};
    }

  private:
    std::vector<qcPeerPair>* Take()
    {
        std::lock_guard<std::mutex> lock(m_mutex);
        if (m_used == m_lanes.size())
            m_lanes.emplace_back();
        m_lanes[m_used].clear();
        return &m_lanes[m_used++];
    }

    std::deque<std::vector<qcPeerPair>> m_lanes; // growing leaves the others where they are
    std::size_t m_used = 0;
    unsigned long long m_step = 0;
    std::mutex m_mutex;
};

/// Tests a candidate and lists it if its triangles penetrate.
inline void qcPeerLanes_Test(qcPeerLanes& lanes, const qcPeerTask& task, const qcPeerPose* poses, uint32_t bodyA,
                             uint32_t triangleA, uint32_t bodyB, uint32_t triangleB)
{
    if (task.self && qcPeerTriangle_AreNeighbours(&task.bodies[bodyA], triangleA, triangleB))
        return;
    double a[9], b[9];
    qcPeerTriangle_Get(&task.bodies[bodyA], &poses[bodyA], triangleA, a);
    qcPeerTriangle_Get(&task.bodies[bodyB], &poses[bodyB], triangleB, b);
    if (qcPeerTriangle_Penetrate(a, b))
        lanes.Mine().push_back({bodyA, triangleA, bodyB, triangleB});
}

/// The functions of a qcPeerLibrary over a class with a constructor (task, method, poses) and a Step(poses): no
/// exception leaves them.
template <class Peer> void* qcPeer_Open(const qcPeerTask* task, uint32_t method, const qcPeerPose* poses)
{
    try
    {
        return new Peer(*task, method, poses);
    }
    catch (const std::exception&)
    {
        return nullptr;
    }
}

template <class Peer> bool qcPeer_Step(void* state, const qcPeerPose* poses, qcPeerAnswer* answer)
{
    try
    {
        *answer = static_cast<Peer*>(state)->Step(poses);
        return true;
    }
    catch (const std::exception&)
    {
        return false;
    }
}

template <class Peer> void qcPeer_Close(void* state)
{
    delete static_cast<Peer*>(state);
}

#endif
