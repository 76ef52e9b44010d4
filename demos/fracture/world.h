// A body that falls on a floor and breaks in the midst of the step of its first hard impact.
#ifndef QC_DEMOS_FRACTURE_WORLD_H
#define QC_DEMOS_FRACTURE_WORLD_H

#include "fracture/body.h"
#include "common/bullet/impact_world.h"
#include "common/bullet/step_costs.h"

#include "quickcullide/bullet.h"

#include <memory>

struct qcFractureRequest
{
    unsigned pieces = 200; ///< Voronoi cells, each with a piece or more
    unsigned seed = 1;
    qcMethod method = qc_methodAuto;
    uint32_t threads = 0;
    const char* save = nullptr;         ///< the file that the pieces go to; null: none
    const qcFracture* loaded = nullptr; ///< pieces to break into; null: they are cut. Must outlive the world
    bool precut = false; ///< pieces and bodies are made with the world, for an impact on the lowest vertex
    bool hulls = false;  ///< pieces collide as convex hulls, by Bullet alone
};

/// How the body broke.
struct qcBreak
{
    bool happened = false;
    btScalar speed = 0;                            ///< speed of the impact on the floor, m/s
    double sitesMs = 0, splitMs = 0, bodiesMs = 0; ///< cells; cutting the mesh; making bodies of the pieces
    size_t pieces = 0, triangles = 0;              ///< of all pieces
    qcMomentum before, after;
    btScalar lostVolume = 0; ///< volume in no piece, relative to the mesh
};

struct qcFractureStep
{
    qcStepCosts costs;
    bool breaks = false;              ///< in this step
    qcMethod method = qc_methodSweep; ///< method of the last query
    const char* fallback = nullptr;   ///< reason why another method than the requested one ran
    size_t bodies = 0;                ///< the whole body, or its pieces
    size_t awake = 0;                 ///< bodies that Bullet simulates
    int pairs = 0;                    ///< of overlapping boxes
    int points = 0;                   ///< contact points in Bullet's manifolds
    btScalar penetration = 0;         ///< depth of the deepest of these points, margins included; m
    btScalar lowest = 0;              ///< height of the lowest vertex above the floor; m
    double energy = 0;                ///< kinetic, J
};

class qcFractureWorld
{
  public:
    /// The model, and the device, which may be null, must outlive the world.
    qcFractureWorld(const qcFractureModel& model, const qcFractureRequest& request, qcDevice* device);
    ~qcFractureWorld();
    qcFractureWorld(const qcFractureWorld&) = delete;
    qcFractureWorld& operator=(const qcFractureWorld&) = delete;

    static constexpr double stepSeconds = 1.0 / 240;

    /// One step. False with a message: the mesh could not be broken, or a query failed.
    bool Step(qcFractureStep* step, std::string* message);

    const qcBreak& Break() const
    {
        return m_break;
    }
    btDiscreteDynamicsWorld& Bullet()
    {
        return m_world;
    }
    qcMeshContact& MeshContact()
    {
        return m_meshContact;
    }
    /// The whole body, or its pieces.
    const std::vector<std::unique_ptr<qcFractureBody>>& Bodies() const
    {
        return m_bodies;
    }

  private:
    void Add(std::unique_ptr<qcFractureBody> body);
    void Cut(const qcFractureBody& whole, const btVector3& impact);
    void NoteContact();
    bool FindImpact(btVector3* place, btScalar* speed) const;
    bool BreakBody(const btVector3& impact);
    bool BreakOnImpact();
    qcMomentum Momentum() const;
    void Measure(qcFractureStep* step) const;

    const qcFractureModel& m_model;
    qcFractureRequest m_request;
    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher;
    qcBroadphase m_broadphase;
    qcStackingSolver m_solver;
    qcMeshContact m_meshContact;
    qcImpactWorld m_world;
    btStaticPlaneShape m_floorShape;
    btRigidBody m_floor;
    std::vector<std::unique_ptr<qcFractureBody>> m_bodies;
    qcFracture m_fracture;
    std::vector<std::unique_ptr<qcFractureBody>> m_pieces; ///< cut, and not yet in the world
    qcBreak m_break;
    std::vector<qcMeshContactStatistics> m_queries; ///< of this step
    uint64_t m_batches = 0;                         ///< total queries at the last NoteContact
    std::string m_failure;
};

#endif
