// The paper's breaking scene: a bunny falls on a dragon, is taken up, and falls again. The dragon stands still, in
// pieces that hold together over bonds. An impact breaks the bonds near it; islands of pieces that are no longer
// connected to the ground become bodies of their own.
#ifndef QC_DEMOS_BREAKING_WORLD_H
#define QC_DEMOS_BREAKING_WORLD_H

#include "breaking/crane.h"
#include "breaking/model.h"
#include "breaking/settling.h"
#include "common/bullet/impact_world.h"
#include "common/bullet/step_costs.h"

#include "quickcullide/bullet.h"

#include <btBulletDynamicsCommon.h>

#include <memory>

struct qcBreakingStep
{
    qcStepCosts costs;
    qcMethod method = qc_methodSweep; ///< method of the last query
    const char* fallback = nullptr;   ///< reason why another method than the requested one ran
    size_t newPieces = 0;             ///< pieces and islands that broke off in this step
    size_t loosePieces = 0;           ///< that have broken off since the beginning
    size_t brokenBonds = 0;           ///< since the beginning
    size_t bodies = 0;                ///< bodies that move, the bunny included
    size_t resting = 0;               ///< pieces that have come to rest
    int pairs = 0;                    ///< of overlapping boxes
    int points = 0;                   ///< contact points in Bullet's manifolds
    btScalar penetration = 0;         ///< depth of the deepest of these points, margins included; m
    int limited = 0, unproven = 0;    ///< see qcMeshContactStatistics
};

/// Where a piece is.
enum qcPieceState
{
    qc_pieceStanding, ///< part of the dragon that stands on the ground
    qc_pieceInIsland, ///< broken off together with others
    qc_pieceSingle    ///< a body of its own
};

class qcBreakingWorld
{
  public:
    /// The model, and the device, which may be null, must outlive the world. `threads`: of the queries, 0: one per
    /// core.
    qcBreakingWorld(const qcBreakingModel& model, qcMethod method, uint32_t threads, qcDevice* device);
    ~qcBreakingWorld();
    qcBreakingWorld(const qcBreakingWorld&) = delete;
    qcBreakingWorld& operator=(const qcBreakingWorld&) = delete;

    static constexpr double stepSeconds = 1.0 / 120;

    /// One step. False with a message: a query failed.
    bool Step(qcBreakingStep* step, std::string* message);

    const qcBreakingModel& Model() const
    {
        return m_model;
    }
    const btTransform& BunnyPlace() const
    {
        return m_bunny.getWorldTransform();
    }
    /// World transform of a piece's shape.
    btTransform PiecePlace(uint32_t piece) const;
    qcPieceState PieceState(uint32_t piece) const
    {
        return m_pieces[piece].state;
    }
    /// The two pieces are parts of one body, or both of the dragon that stands.
    bool AreJoined(uint32_t a, uint32_t b) const
    {
        return m_pieces[a].state == m_pieces[b].state && m_pieces[a].state != qc_pieceSingle &&
               m_pieces[a].island == m_pieces[b].island;
    }
    /// Number of times that the bunny has been dropped.
    size_t Drops() const
    {
        return m_crane.Drops();
    }
    btDiscreteDynamicsWorld& Bullet()
    {
        return m_world;
    }
    qcMeshContact& MeshContact()
    {
        return m_meshContact;
    }

  private:
    /// Several pieces in one body.
    struct Island
    {
        qcIsland island;
        btCompoundShape shape;
        std::unique_ptr<btRigidBody> body;
    };

    struct Piece
    {
        std::unique_ptr<btRigidBody> body; ///< in the world unless the piece is in an island
        Island* island = nullptr;
        qcPieceState state = qc_pieceStanding;
    };

    struct Impact
    {
        btRigidBody *bodyA = nullptr, *bodyB = nullptr;
        qcImpact onPiece;                    ///< in the dragon's frame; of pieces of bodyB
        btVector3 place, normal;             ///< in world space; towards bodyA
        btScalar speed = 0, inverseMass = 0; ///< closing speed, and inverse of the mass that the impact has there
    };

    btVector3 FindTarget() const;
    void Warm();
    void NoteContact();
    void NoteBlow();
    bool Break();
    std::vector<Impact> FindImpacts() const;
    bool IsBonded(const btRigidBody& body) const;
    void Weigh(const btPersistentManifold& manifold, bool swapped, Impact* impact) const;
    uint32_t NearestPiece(const btRigidBody& body, const btVector3& place) const;
    btTransform FrameOf(const btRigidBody& body) const;
    void Strike(const Impact& impact);
    size_t Separate();
    void Release(const qcIsland& island);
    btRigidBody* Join(const qcIsland& island, const qcPieceMotion& motion);
    void Measure(qcBreakingStep* step) const;

    const qcBreakingModel& m_model;
    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher;
    qcBroadphase m_broadphase;
    btSequentialImpulseConstraintSolver m_solver;
    qcMeshContact m_meshContact;
    qcImpactWorld m_world;
    btStaticPlaneShape m_floorShape;
    btRigidBody m_floor;
    btRigidBody m_bunny;
    std::vector<Piece> m_pieces;
    qcCrane m_crane; ///< its first target depends on the pieces
    qcSettling m_settling;
    std::vector<std::unique_ptr<Island>> m_islands;
    std::vector<double> m_bondEnergies;
    std::vector<qcMeshContactStatistics> m_queries; ///< of this step
    uint64_t m_batches = 0;                         ///< total queries at the last NoteContact
    Impact m_blow;                                  ///< of the previous step; energy 0: none
    btScalar m_bunnySpeed = 0;                      ///< before this step; 0 while it is carried
    size_t m_newPieces = 0;                         ///< in this step
    double m_breakMs = 0;                           ///< in this step
};

#endif
