// Embree's rtcCollide: user geometry, one primitive a triangle, a scene a body. Its callback drops neighbours and tests
// triangles.
#include "bench/peers/common.h"

#include <embree3/rtcore.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <stdexcept>
#include <string>

namespace
{

enum Method
{
    method_refit,   ///< the tree of the first frame, fitted to new bounds
    method_rebuild, ///< low quality, built anew in each step, which Embree recommends for moving geometry
    method_medium   ///< the default quality, built anew in each step
};

const qcPeerMethod s_methods[] = {{"embree-refit", true}, {"embree-rebuild", true}, {"embree-medium", true}};

class Embree
{
  public:
    Embree(const qcPeerTask& task, uint32_t method, const qcPeerPose* poses)
        : m_task(task), m_threads(tbb::global_control::max_allowed_parallelism, task.threads),
          m_device(rtcNewDevice(("threads=" + std::to_string(task.threads)).c_str())),
          m_poses(poses, poses + task.bodyCount), m_bodies(task.bodyCount)
    {
        if (m_device == nullptr)
            throw std::runtime_error("rtcNewDevice");
        if (task.self)
            m_boxes.resize(task.bodies[0].triangleCount);
        for (uint32_t i = 0; i < task.bodyCount; ++i)
            Add(i, method);
    }

    ~Embree()
    {
        for (Body& body : m_bodies)
            rtcReleaseScene(body.scene);
        rtcReleaseDevice(m_device);
    }

    qcPeerAnswer Step(const qcPeerPose* poses)
    {
        Take(poses);
        m_lanes.Clear();
        // One body after the other: Embree spreads the work of each over the threads.
        for (Body& body : m_bodies)
        {
            rtcCommitGeometry(body.geometry);
            rtcCommitScene(body.scene);
        }
        if (m_task.self)
        {
            Pair pair{this, 0, 0};
            rtcCollide(m_bodies[0].scene, m_bodies[0].scene, CollideSelf, &pair);
        }
        else
            CollideBodies();
        return m_lanes.Join();
    }

  private:
    struct Body
    {
        Embree* owner;
        uint32_t index;
        RTCGeometry geometry; ///< owned by the scene
        RTCScene scene;
        std::vector<float> positions; ///< of this step
    };

    /// The context of a callback.
    struct Pair
    {
        Embree* owner;
        uint32_t bodyA, bodyB;
    };

    void Add(uint32_t index, uint32_t method)
    {
        Body& body = m_bodies[index];
        body = {this, index, rtcNewGeometry(m_device, RTC_GEOMETRY_TYPE_USER), rtcNewScene(m_device), {}};
        rtcSetGeometryBuildQuality(body.geometry, method == method_refit     ? RTC_BUILD_QUALITY_REFIT
                                                  : method == method_rebuild ? RTC_BUILD_QUALITY_LOW
                                                                             : RTC_BUILD_QUALITY_MEDIUM);
        rtcSetGeometryUserPrimitiveCount(body.geometry, m_task.bodies[index].triangleCount);
        rtcSetGeometryUserData(body.geometry, &body);
        rtcSetGeometryBoundsFunction(body.geometry, FindBounds, nullptr);
        rtcSetSceneFlags(body.scene, method == method_medium ? RTC_SCENE_FLAG_NONE : RTC_SCENE_FLAG_DYNAMIC);
        rtcSetSceneBuildQuality(body.scene, method == method_medium ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_LOW);
        rtcCommitGeometry(body.geometry);
        rtcAttachGeometry(body.scene, body.geometry);
        rtcReleaseGeometry(body.geometry);
    }

    /// Copies positions, which may lie in main memory. Read in order here, they are in the cache when Embree requests
    /// the bounds of triangles in the order of its tree. That saves a tenth of the whole step of 250 K triangles.
    void Take(const qcPeerPose* poses)
    {
        for (uint32_t i = 0; i < m_bodies.size(); ++i)
        {
            m_poses[i] = poses[i];
            if (poses[i].floats == nullptr)
                continue;
            std::vector<float>& copy = m_bodies[i].positions;
            copy.assign(poses[i].floats, poses[i].floats + 3 * std::size_t(m_task.bodies[i].vertexCount));
            m_poses[i].floats = copy.data();
        }
    }

    static void FindBounds(const RTCBoundsFunctionArguments* arguments)
    {
        const Body* body = static_cast<const Body*>(arguments->geometryUserPtr);
        Embree* e = body->owner;
        qcPeerBox box = qcPeerBox_Find(e->m_task.bodies[body->index], e->m_poses[body->index], arguments->primID);
        if (e->m_task.self)
            e->m_boxes[arguments->primID] = box;
        RTCBounds* bounds = arguments->bounds_o;
        bounds->lower_x = box.lower[0];
        bounds->lower_y = box.lower[1];
        bounds->lower_z = box.lower[2];
        bounds->upper_x = box.upper[0];
        bounds->upper_y = box.upper[1];
        bounds->upper_z = box.upper[2];
    }

    static void CollideSelf(void* context, RTCCollision* collisions, unsigned count)
    {
        Embree* e = static_cast<Pair*>(context)->owner;
        for (unsigned i = 0; i < count; ++i)
        {
            // Pairs come in both orders. A leaf of a refitted tree holds several triangles, whose own boxes may be
            // disjoint.
            uint32_t a = collisions[i].primID0, b = collisions[i].primID1;
            if (a < b && qcPeerBox_Overlap(e->m_boxes[a], e->m_boxes[b]))
                qcPeerLanes_Test(e->m_lanes, e->m_task, e->m_poses.data(), 0, a, 0, b);
        }
    }

    static void CollideTwo(void* context, RTCCollision* collisions, unsigned count)
    {
        const Pair* pair = static_cast<Pair*>(context);
        Embree* e = pair->owner;
        for (unsigned i = 0; i < count; ++i)
            qcPeerLanes_Test(e->m_lanes, e->m_task, e->m_poses.data(), pair->bodyA, collisions[i].primID0, pair->bodyB,
                             collisions[i].primID1);
    }

    void CollideBodies()
    {
        std::vector<RTCBounds> bounds(m_bodies.size());
        for (const Body& body : m_bodies)
            rtcGetSceneBounds(body.scene, &bounds[body.index]);
        m_pairs.clear();
        for (uint32_t a = 0; a < m_bodies.size(); ++a)
        {
            for (uint32_t b = a + 1; b < m_bodies.size(); ++b)
            {
                const RTCBounds &x = bounds[a], &y = bounds[b];
                if (x.lower_x <= y.upper_x && y.lower_x <= x.upper_x && x.lower_y <= y.upper_y &&
                    y.lower_y <= x.upper_y && x.lower_z <= y.upper_z && y.lower_z <= x.upper_z)
                    m_pairs.push_back({this, a, b});
            }
        }
        tbb::parallel_for(std::size_t(0), m_pairs.size(),
                          [this](std::size_t i)
                          {
                              Pair& pair = m_pairs[i];
                              rtcCollide(m_bodies[pair.bodyA].scene, m_bodies[pair.bodyB].scene, CollideTwo, &pair);
                          });
    }

    const qcPeerTask& m_task;
    tbb::global_control m_threads;
    RTCDevice m_device;
    std::vector<qcPeerPose> m_poses;
    std::vector<Body> m_bodies;
    std::vector<qcPeerBox> m_boxes; ///< self only
    std::vector<Pair> m_pairs;
    qcPeerLanes m_lanes;
};

} // namespace

extern "C" __attribute__((visibility("default"))) const qcPeerLibrary* qcPeer_GetLibrary()
{
    static const qcPeerLibrary library = {"Embree " RTC_VERSION_STRING, s_methods,           3,
                                          qcPeer_Open<Embree>,          qcPeer_Step<Embree>, qcPeer_Close<Embree>};
    return &library;
}
