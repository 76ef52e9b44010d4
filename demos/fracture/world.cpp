// The falling body. It breaks between collision detection, which finds the impact, and the solver. The pieces inherit
// the motion of the body before the impact. A second detection in the same step finds their contacts with the floor and
// with each other. If the body broke after the solver, all pieces would have been stopped as one.
#include "fracture/world.h"

#include "fracture/pieces.h"
#include "fracture/sites.h"

#include "common/stopwatch.h"

#include <algorithm>

namespace
{
constexpr btScalar s_density = 2500;         // of stone, kg/m3
constexpr btScalar s_height = btScalar(0.9); // of the fall, m
constexpr btScalar s_hardSpeed = 2;          // an impact that breaks it, m/s
constexpr int s_pointsOfPiece = 25;          // 200 pieces have up to 4 500 contact points after they have appeared

btRigidBody::btRigidBodyConstructionInfo Floor(btCollisionShape* shape)
{
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shape);
    info.m_friction = btScalar(0.8);
    return info;
}
} // namespace

qcFractureWorld::qcFractureWorld(const qcFractureModel& model, const qcFractureRequest& request, qcDevice* device)
    : m_model(model), m_request(request), m_dispatcher(&m_configuration), m_meshContact(device),
      m_world([this] { NoteContact(); }, [this] { return BreakOnImpact(); }, &m_dispatcher, &m_broadphase, &m_solver,
              &m_configuration),
      m_floorShape(btVector3(0, 1, 0), 0), m_floor(Floor(&m_floorShape))
{
    m_meshContact.addTo(&m_world);
    m_meshContact.setMethod(request.method);
    m_meshContact.setThreadCount(request.threads);
    // With ten layers of pieces, the impulses of the upper ones don't reach the lowest in Bullet's 10 iterations.
    m_world.getSolverInfo().m_numIterations = 30;
    // Penetration of any depth is resolved without adding speed, most of it in one step.
    m_world.getSolverInfo().m_splitImpulsePenetrationThreshold = 0;
    m_world.getSolverInfo().m_erp2 = btScalar(0.8);
    // With friction along one direction only, pieces of a heap creep sideways of it: by 6 mm/s at rest, and by 0.4 mm/s
    // with two.
    m_world.getSolverInfo().m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    m_solver.reserveContacts(s_pointsOfPiece * int(request.pieces));
    m_world.addRigidBody(&m_floor);
    // The body lands on an edge.
    btTransform place(btMatrix3x3(btQuaternion(btVector3(0, 0, 1), btScalar(0.35))) * model.upright);
    auto whole = std::make_unique<qcFractureBody>(model.vertices, model.indices, uint32_t(model.indices.size() / 3),
                                                  model.volume * s_density, model.inertia, place);
    place.setOrigin(btVector3(0, s_height - whole->Lowest(), 0));
    whole->body.setWorldTransform(place);
    whole->body.setInterpolationWorldTransform(place);
    whole->body.setAngularVelocity(btVector3(btScalar(0.2), btScalar(0.4), btScalar(0.1)));
    if (request.precut)
        Cut(*whole, whole->LowestVertex());
    Add(std::move(whole));
}

qcFractureWorld::~qcFractureWorld()
{
    for (const auto& body : m_bodies)
        m_world.removeRigidBody(&body->body);
    m_world.removeRigidBody(&m_floor);
}

void qcFractureWorld::Add(std::unique_ptr<qcFractureBody> body)
{
    m_world.addRigidBody(&body->body);
    m_bodies.push_back(std::move(body));
}

/// Appends the statistics of the last query, if there was one since the last call.
void qcFractureWorld::NoteContact()
{
    const qcMeshContactStatistics& statistics = m_meshContact.getStatistics();
    if (statistics.batches != m_batches)
        m_queries.push_back(statistics);
    m_batches = statistics.batches;
}

/// The contact with the floor of the highest closing speed in this step; false: too slow to break the body.
bool qcFractureWorld::FindImpact(btVector3* place, btScalar* speed) const
{
    const btRigidBody& body = m_bodies.front()->body;
    *speed = s_hardSpeed;
    bool found = false;
    for (int m = 0; m < m_dispatcher.getNumManifolds(); m++)
    {
        // The world holds only the body and the floor.
        const btPersistentManifold& manifold = *m_dispatcher.getManifoldByIndexInternal(m);
        for (int i = 0; i < manifold.getNumContacts(); i++)
        {
            const btManifoldPoint& point = manifold.getContactPoint(i);
            btVector3 velocity =
                body.getVelocityInLocalPoint(point.getPositionWorldOnB() - body.getWorldTransform().getOrigin());
            btScalar closing =
                velocity.dot(manifold.getBody0() == &body ? -point.m_normalWorldOnB : point.m_normalWorldOnB);
            if (closing < *speed || point.getDistance() > closing * btScalar(stepSeconds))
                continue;
            *speed = closing;
            *place = point.getPositionWorldOnB();
            found = true;
        }
    }
    return found;
}

/// Breaks the body at its first hard impact. False: there is none in this step, or the body can't be broken.
bool qcFractureWorld::BreakOnImpact()
{
    btVector3 place;
    return !m_break.happened && FindImpact(&place, &m_break.speed) && BreakBody(place);
}

qcMomentum qcFractureWorld::Momentum() const
{
    qcMomentum sum;
    for (const auto& body : m_bodies)
        body->AddMomentum(&sum);
    return sum;
}

/// Cuts the body, and makes bodies of the pieces. `impact`: in the body's frame.
void qcFractureWorld::Cut(const qcFractureBody& whole, const btVector3& impact)
{
    double start = qcStopwatch_NowMs();
    qcFractureDef def;
    def.vertices = m_model.vertices;
    def.indices = m_model.indices;
    def.sites = qcScatterSitesInside(whole.shape, m_request.pieces, m_request.seed, impact);
    double scattered = qcStopwatch_NowMs();
    m_fracture = m_request.loaded != nullptr ? *m_request.loaded : qcSplitAndSave(def, m_request.save);
    double split = qcStopwatch_NowMs();
    m_failure = m_fracture.message;
    for (const qcPiece& piece : m_fracture.pieces)
    {
        qcPieceMotion motion = qcMotionOfPiece(whole.body, m_fracture, piece);
        m_pieces.push_back(std::make_unique<qcFractureBody>(piece.vertices, piece.indices, piece.firstCutTriangle,
                                                            motion.mass, piece.inertia, motion.transform));
        m_pieces.back()->cuts = qcCutNumbers(piece);
        if (m_request.hulls)
            m_pieces.back()->UseHull();
        m_break.triangles += piece.indices.size() / 3;
    }
    m_break.lostVolume = m_fracture.volume > 0 ? btScalar(m_fracture.lostVolume / m_fracture.volume) : btScalar(0);
    m_break.sitesMs = scattered - start;
    m_break.splitMs = split - scattered;
    m_break.bodiesMs = qcStopwatch_NowMs() - split;
}

/// Replaces the body by its pieces.
bool qcFractureWorld::BreakBody(const btVector3& impact)
{
    std::unique_ptr<qcFractureBody> whole = std::move(m_bodies.front());
    m_break.happened = true;
    whole->AddMomentum(&m_break.before);
    if (m_request.precut)
        m_break.sitesMs = m_break.splitMs = m_break.bodiesMs = 0;
    else
        Cut(*whole, whole->body.getWorldTransform().invXform(impact));
    double start = qcStopwatch_NowMs();
    m_world.removeRigidBody(&whole->body);
    m_bodies.clear();
    for (size_t i = 0; i < m_pieces.size(); i++)
    {
        qcPieceMotion motion = qcMotionOfPiece(whole->body, m_fracture, m_fracture.pieces[i]);
        btRigidBody& body = m_pieces[i]->body;
        body.setWorldTransform(motion.transform);
        body.setInterpolationWorldTransform(motion.transform);
        body.setLinearVelocity(motion.linearVelocity);
        body.setAngularVelocity(motion.angularVelocity);
        Add(std::move(m_pieces[i]));
        // The world has applied the gravity of this step before the piece was added.
        body.applyGravity();
    }
    m_pieces.clear();
    m_break.pieces = m_bodies.size();
    m_break.after = Momentum();
    m_break.bodiesMs += qcStopwatch_NowMs() - start;
    return m_fracture.status == qc_statusOk;
}

/// Fills the measures at the end of a step.
void qcFractureWorld::Measure(qcFractureStep* step) const
{
    step->bodies = m_bodies.size();
    step->pairs = m_broadphase.getOverlappingPairCache()->getNumOverlappingPairs();
    step->lowest = m_bodies.empty() ? btScalar(0) : BT_LARGE_FLOAT;
    for (const auto& body : m_bodies)
    {
        step->awake += body->body.isActive();
        step->lowest = std::min(step->lowest, body->Lowest());
        step->energy += body->KineticEnergy();
    }
    for (int m = 0; m < m_dispatcher.getNumManifolds(); m++)
    {
        const btPersistentManifold& manifold = *m_dispatcher.getManifoldByIndexInternal(m);
        step->points += manifold.getNumContacts();
        for (int i = 0; i < manifold.getNumContacts(); i++)
            step->penetration = std::max(step->penetration, -manifold.getContactPoint(i).getDistance());
    }
}

bool qcFractureWorld::Step(qcFractureStep* step, std::string* message)
{
    bool broken = m_break.happened;
    m_queries.clear();
    step->costs = qcTimeStep(&m_world, stepSeconds);
    step->breaks = m_break.happened && !broken;
    if (step->breaks)
        step->costs.Move(qc_costRest, qc_costBreak, m_break.sitesMs + m_break.splitMs + m_break.bodiesMs);
    for (const qcMeshContactStatistics& query : m_queries)
        step->costs.MoveQuery(query);
    const qcMeshContactStatistics& statistics = m_meshContact.getStatistics();
    step->method = statistics.method;
    step->fallback = statistics.fallback;
    Measure(step);
    if (m_failure.empty() && statistics.status != qc_statusOk)
        m_failure = std::string("contact of meshes: ") + qcStatus_Name(statistics.status);
    *message = m_failure;
    return m_failure.empty();
}
