// CGAL's box_self_intersection_d and box_intersection_d over the boxes of the triangles; nothing is kept from step to
// step. Between two bodies only triangles whose boxes overlap the other body's box are tested.
#include "bench/peers/common.h"

#include <CGAL/box_intersection_d.h>
#include <CGAL/version_macros.h>
#include <tbb/global_control.h>

namespace
{

const qcPeerMethod s_methods[] = {{"cgal-boxes", true}};

/// The number of boxes below which it compares all with all. On cloths of 20 K and 250 K its default, 10, takes twice
/// as long as this, 100 half as long again, 1000 the same.
const std::ptrdiff_t s_cutoff = 2000;

/// A triangle's box, with the members that CGAL requires.
struct Box
{
    typedef float NT;
    typedef uint32_t ID;

    static int dimension()
    {
        return 3;
    }
    float min_coord(int axis) const
    {
        return box.lower[axis];
    }
    float max_coord(int axis) const
    {
        return box.upper[axis];
    }
    uint32_t id() const
    {
        return triangle;
    }

    qcPeerBox box;
    uint32_t triangle;
};

class Boxes
{
  public:
    Boxes(const qcPeerTask& task, uint32_t, const qcPeerPose*)
        : m_task(task), m_threads(tbb::global_control::max_allowed_parallelism, task.threads), m_boxes(task.bodyCount),
          m_whole(task.bodyCount)
    {
        for (uint32_t i = 0; i < task.bodyCount; ++i)
            m_boxes[i].resize(task.bodies[i].triangleCount);
    }

    qcPeerAnswer Step(const qcPeerPose* poses)
    {
        m_poses = poses;
        m_lanes.Clear();
        if (m_task.threads > 1)
            Run<CGAL::Parallel_tag>();
        else
            Run<CGAL::Sequential_tag>();
        return m_lanes.Join();
    }

  private:
    typedef std::vector<const Box*> List;

    /// Finds the box around a body, from the boxes of its triangles.
    void FindBoxes(uint32_t body)
    {
        const float far = std::numeric_limits<float>::infinity();
        qcPeerBox whole = {{far, far, far}, {-far, -far, -far}};
        for (uint32_t i = 0; i < m_task.bodies[body].triangleCount; ++i)
        {
            qcPeerBox box = qcPeerBox_Find(m_task.bodies[body], m_poses[body], i);
            m_boxes[body][i] = {box, i};
            for (int axis = 0; axis < 3; ++axis)
            {
                whole.lower[axis] = std::min(whole.lower[axis], box.lower[axis]);
                whole.upper[axis] = std::max(whole.upper[axis], box.upper[axis]);
            }
        }
        m_whole[body] = whole;
    }

    void Gather(uint32_t body, const qcPeerBox& reach, List& list) const
    {
        list.clear();
        for (const Box& box : m_boxes[body])
        {
            if (qcPeerBox_Overlap(box.box, reach))
                list.push_back(&box);
        }
    }

    template <class Concurrency> void Run()
    {
        for (uint32_t i = 0; i < m_task.bodyCount; ++i)
            FindBoxes(i);
        if (m_task.self)
        {
            Gather(0, m_whole[0], m_listA);
            CGAL::box_self_intersection_d<Concurrency>(
                m_listA.begin(), m_listA.end(),
                [this](const Box* a, const Box* b)
                { qcPeerLanes_Test(m_lanes, m_task, m_poses, 0, a->id(), 0, b->id()); },
                s_cutoff);
            return;
        }
        for (uint32_t a = 0; a < m_task.bodyCount; ++a)
        {
            for (uint32_t b = a + 1; b < m_task.bodyCount; ++b)
            {
                if (!qcPeerBox_Overlap(m_whole[a], m_whole[b]))
                    continue;
                Gather(a, m_whole[b], m_listA);
                Gather(b, m_whole[a], m_listB);
                CGAL::box_intersection_d<Concurrency>(
                    m_listA.begin(), m_listA.end(), m_listB.begin(), m_listB.end(),
                    [this, a, b](const Box* x, const Box* y)
                    { qcPeerLanes_Test(m_lanes, m_task, m_poses, a, x->id(), b, y->id()); },
                    s_cutoff);
            }
        }
    }

    const qcPeerTask& m_task;
    tbb::global_control m_threads;
    const qcPeerPose* m_poses = nullptr;
    std::vector<std::vector<Box>> m_boxes;
    std::vector<qcPeerBox> m_whole; ///< of each body
    List m_listA, m_listB;
    qcPeerLanes m_lanes;
};

} // namespace

extern "C" __attribute__((visibility("default"))) const qcPeerLibrary* qcPeer_GetLibrary()
{
    static const qcPeerLibrary library = {"CGAL " CGAL_VERSION_STR, s_methods,          1,
                                          qcPeer_Open<Boxes>,       qcPeer_Step<Boxes>, qcPeer_Close<Boxes>};
    return &library;
}
