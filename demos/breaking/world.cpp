// The dragon breaks between collision detection, which finds the impacts, and the solver: the solver then meets pieces,
// not a body that stops the bunny as a whole. The energy that breaks bonds is taken from the impact.
#include "breaking/world.h"

#include "common/stopwatch.h"
#include "quickcullide/bullet_positions.h"

#include <algorithm>

namespace
{
constexpr btScalar s_density = 2500;      // of stone, kg/m3
constexpr double s_toughness = 3000;      // energy of a break, J/m2
constexpr btScalar s_hardSpeed = 1;       // below that nothing breaks, m/s
constexpr double s_hardEnergy = 100;      // nor below that, J
constexpr btScalar s_bunnyDensity = 4000; // kg/m3

// m: parts of the dragon that are lower by that count as equally high.
constexpr btScalar s_nearlyAsHigh = btScalar(0.3);

btRigidBody::btRigidBodyConstructionInfo Material(btScalar mass, btCollisionShape* shape, const btVector3& inertia,
                                                  const btTransform& place)
{
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
    info.m_startWorldTransform = place;
    info.m_friction = btScalar(0.7);
    info.m_rollingFriction = btScalar(0.01);
    info.m_linearSleepingThreshold = btScalar(0.4);
    info.m_angularSleepingThreshold = btScalar(0.8);
    return info;
}

btScalar BunnyMass(const qcBreakingModel& model)
{
    return btScalar(model.bunny.volume) * s_bunnyDensity;
}
} // namespace

qcBreakingWorld::qcBreakingWorld(const qcBreakingModel& model, qcMethod method, uint32_t threads, qcDevice* device)
    : m_model(model), m_dispatcher(&m_configuration), m_meshContact(device),
      m_world([this] { NoteContact(); }, [this] { return Break(); }, &m_dispatcher, &m_broadphase, &m_solver,
              &m_configuration),
      m_floorShape(btVector3(0, 1, 0), 0),
      m_floor(Material(0, &m_floorShape, btVector3(0, 0, 0), btTransform::getIdentity())),
      m_bunny(Material(BunnyMass(model), model.bunny.shape.get(), model.bunny.inertia * BunnyMass(model),
                       btTransform::getIdentity())),
      m_pieces(model.fracture.pieces.size()),
      m_crane(&m_bunny, BunnyMass(model), model.bunny.inertia * BunnyMass(model), model.bunny.upright.getRotation(),
              [this] { return FindTarget(); }),
      m_settling(&m_world), m_bondEnergies(qcBondEnergies(model.fracture, s_toughness))
{
    m_meshContact.addTo(&m_world);
    m_meshContact.setMethod(method);
    m_meshContact.setThreadCount(threads);
    m_world.getSolverInfo().m_numIterations = 30;
    m_world.getSolverInfo().m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    // Penetration of any depth is resolved without adding speed.
    m_world.getSolverInfo().m_splitImpulsePenetrationThreshold = 0;
    m_world.addRigidBody(&m_floor);
    for (size_t i = 0; i < m_pieces.size(); i++)
    {
        const qcPiece& piece = model.fracture.pieces[i];
        btScalar mass = btScalar(piece.volume) * s_density;
        m_pieces[i].body =
            std::make_unique<btRigidBody>(Material(mass, model.shapes[i].get(), piece.inertia * mass, piece.frame));
        m_pieces[i].body->setUserIndex(int(i));
        m_world.addRigidBody(m_pieces[i].body.get());
        qcFreezeBody(m_pieces[i].body.get());
    }
    Warm();
    m_world.addRigidBody(&m_bunny);
}

/// One step with a body whose box holds the whole dragon, but which comes near no piece: collision detection makes its
/// trees of all pieces now, not in the steps in which they break off.
void qcBreakingWorld::Warm()
{
    const btScalar far = 1;
    std::vector<btVector3> vertices;
    for (const btVector3& corner :
         {m_model.lower - btVector3(far, -far, far), m_model.upper + btVector3(far, far, far)})
        for (int axis = 0; axis < 3; axis++)
        {
            btVector3 vertex = corner;
            vertex[axis] += btScalar(0.01);
            vertices.push_back(vertex);
        }
    const uint32_t indices[] = {0, 1, 2, 3, 4, 5};
    qcMeshShape shape(vertices.data(), qcBulletPositions, sizeof(btVector3), 6, indices, 2);
    btRigidBody probe(Material(1, &shape, btVector3(1, 1, 1), btTransform::getIdentity()));
    m_world.addRigidBody(&probe);
    m_world.stepSimulation(btScalar(stepSeconds), 0);
    m_world.removeRigidBody(&probe);
    NoteContact();
}

/// The top of the dragon, or of a part of it that is nearly as high and further from where the bunny fell before.
btVector3 qcBreakingWorld::FindTarget() const
{
    std::vector<btVector3> tops;
    btScalar highest = 0;
    for (uint32_t i = 0; i < m_model.shapes.size(); i++)
    {
        if (m_pieces[i].state != qc_pieceStanding)
            continue;
        btVector3 lower, upper;
        m_model.shapes[i]->getAabb(m_model.fracture.pieces[i].frame, lower, upper);
        tops.push_back((lower + upper) / 2);
        tops.back().setY(upper.y());
        highest = std::max(highest, upper.y());
    }
    btVector3 best(0, 0, 0), from = m_bunny.getWorldTransform().getOrigin();
    btScalar bestDistance = -1;
    for (const btVector3& top : tops)
    {
        btScalar distance = btVector3(top.x() - from.x(), 0, top.z() - from.z()).length();
        if (top.y() > highest - s_nearlyAsHigh && distance > bestDistance)
        {
            best = top;
            bestDistance = distance;
        }
    }
    return best;
}

qcBreakingWorld::~qcBreakingWorld()
{
    for (int i = m_world.getNumCollisionObjects() - 1; i >= 0; i--)
        m_world.removeCollisionObject(m_world.getCollisionObjectArray()[i]);
}

/// Appends the statistics of the last query, if there was one since the last call.
void qcBreakingWorld::NoteContact()
{
    const qcMeshContactStatistics& statistics = m_meshContact.getStatistics();
    if (statistics.batches != m_batches)
        m_queries.push_back(statistics);
    m_batches = statistics.batches;
}

btTransform qcBreakingWorld::PiecePlace(uint32_t index) const
{
    const Piece& piece = m_pieces[index];
    if (piece.state != qc_pieceInIsland)
        return piece.body->getWorldTransform();
    return piece.island->body->getWorldTransform() * piece.island->island.frame.inverse() *
           m_model.fracture.pieces[index].frame;
}

//  ---- impacts ---------------------------------------------------------------------------------------

/// The body is of several pieces, or one of those that stand.
bool qcBreakingWorld::IsBonded(const btRigidBody& body) const
{
    return body.getUserPointer() != nullptr ||
           (body.getUserIndex() >= 0 && m_pieces[size_t(body.getUserIndex())].state == qc_pieceStanding);
}

/// The frame of the body in the dragon's frame.
btTransform qcBreakingWorld::FrameOf(const btRigidBody& body) const
{
    auto* island = static_cast<const Island*>(body.getUserPointer());
    return island != nullptr ? island->island.frame : m_model.fracture.pieces[size_t(body.getUserIndex())].frame;
}

/// The piece of a bonded body whose box is nearest to a place in world space.
uint32_t qcBreakingWorld::NearestPiece(const btRigidBody& body, const btVector3& place) const
{
    auto* island = static_cast<const Island*>(body.getUserPointer());
    if (island == nullptr)
        return uint32_t(body.getUserIndex());
    uint32_t nearest = island->island.pieces[0];
    btScalar least = BT_LARGE_FLOAT;
    for (uint32_t index : island->island.pieces)
    {
        btVector3 lower, upper, inside = place;
        m_model.shapes[index]->getAabb(PiecePlace(index), lower, upper);
        inside.setMax(lower);
        inside.setMin(upper);
        btScalar distance = inside.distance(place);
        if (distance < least)
        {
            least = distance;
            nearest = index;
        }
    }
    return nearest;
}

/// Keeps the point of a manifold that closes fastest, if that is faster than the impact's.
void qcBreakingWorld::Weigh(const btPersistentManifold& manifold, bool swapped, Impact* impact) const
{
    for (int i = 0; i < manifold.getNumContacts(); i++)
    {
        const btManifoldPoint& point = manifold.getContactPoint(i);
        btVector3 normal = swapped ? -point.m_normalWorldOnB : point.m_normalWorldOnB;
        btVector3 place = point.getPositionWorldOnB();
        btVector3 relative =
            impact->bodyA->getVelocityInLocalPoint(place - impact->bodyA->getWorldTransform().getOrigin()) -
            impact->bodyB->getVelocityInLocalPoint(place - impact->bodyB->getWorldTransform().getOrigin());
        btScalar closing = -relative.dot(normal);
        if (closing <= impact->speed || point.getDistance() > closing * btScalar(stepSeconds))
            continue;
        impact->speed = closing;
        impact->place = place;
        impact->normal = normal;
    }
}

/// The hardest impact in this step for each body that hits the dragon, and for each island.
std::vector<qcBreakingWorld::Impact> qcBreakingWorld::FindImpacts() const
{
    std::vector<Impact> impacts;
    for (int m = 0; m < m_dispatcher.getNumManifolds(); m++)
    {
        const btPersistentManifold& manifold = *m_dispatcher.getManifoldByIndexInternal(m);
        for (bool swapped : {false, true})
        {
            Impact impact;
            impact.bodyA =
                const_cast<btRigidBody*>(btRigidBody::upcast(swapped ? manifold.getBody1() : manifold.getBody0()));
            impact.bodyB =
                const_cast<btRigidBody*>(btRigidBody::upcast(swapped ? manifold.getBody0() : manifold.getBody1()));
            impact.speed = s_hardSpeed;
            if (!IsBonded(*impact.bodyB))
                continue;
            Weigh(manifold, swapped, &impact);
            if (impact.speed <= s_hardSpeed)
                continue;
            impact.inverseMass = impact.bodyA->computeImpulseDenominator(impact.place, impact.normal) +
                                 impact.bodyB->computeImpulseDenominator(impact.place, impact.normal);
            impact.onPiece.energy = 0.5 * double(impact.speed * impact.speed / impact.inverseMass);
            if (impact.onPiece.energy < s_hardEnergy)
                continue;
            auto same = std::find_if(impacts.begin(), impacts.end(),
                                     [&](const Impact& other) {
                                         return impact.bodyB == other.bodyB ||
                                                (impact.bodyA == other.bodyA && impact.bodyA != &m_floor);
                                     });
            if (same == impacts.end())
                impacts.push_back(impact);
            else if (same->onPiece.energy < impact.onPiece.energy)
                *same = impact;
        }
    }
    return impacts;
}

/// Keeps the hardest blow that the solver has passed on to the dragon in this step, over rubble that lies on it, say:
/// the impulse times half the bunny's speed. It breaks bonds in the next step.
void qcBreakingWorld::NoteBlow()
{
    m_blow = Impact();
    for (int m = 0; m < m_dispatcher.getNumManifolds() && m_bunnySpeed > s_hardSpeed; m++)
    {
        const btPersistentManifold& manifold = *m_dispatcher.getManifoldByIndexInternal(m);
        btScalar impulse = 0;
        for (int i = 0; i < manifold.getNumContacts(); i++)
            impulse += manifold.getContactPoint(i).m_appliedImpulse;
        double energy = std::min(0.5 * double(impulse * m_bunnySpeed),
                                 0.5 * double(BunnyMass(m_model) * m_bunnySpeed * m_bunnySpeed));
        for (const btCollisionObject* object : {manifold.getBody0(), manifold.getBody1()})
        {
            auto* body = const_cast<btRigidBody*>(btRigidBody::upcast(object));
            if (energy < std::max(s_hardEnergy, m_blow.onPiece.energy) || !IsBonded(*body))
                continue;
            m_blow.bodyB = body;
            m_blow.place = manifold.getContactPoint(0).getPositionWorldOnB();
            m_blow.onPiece.energy = energy;
        }
    }
}

/// Breaks bonds, and takes the energy of that from the two bodies. After a blow they have lost it already.
void qcBreakingWorld::Strike(const Impact& impact)
{
    qcImpact onPiece = impact.onPiece;
    onPiece.piece = NearestPiece(*impact.bodyB, impact.place);
    onPiece.place = FrameOf(*impact.bodyB) * (impact.bodyB->getWorldTransform().inverse() * impact.place);
    double taken = qcBreakBonds(m_model.fracture, onPiece, &m_bondEnergies);
    if (impact.bodyA == nullptr)
        return;
    btScalar speed = btSqrt(btScalar(std::max(0.0, 1 - taken / onPiece.energy))) * impact.speed;
    btVector3 impulse = impact.normal * ((impact.speed - speed) / impact.inverseMass);
    impact.bodyA->applyImpulse(impulse, impact.place - impact.bodyA->getWorldTransform().getOrigin());
    impact.bodyB->applyImpulse(-impulse, impact.place - impact.bodyB->getWorldTransform().getOrigin());
}

//  ---- breaking --------------------------------------------------------------------------------------

/// Makes a body of an island that has broken off.
void qcBreakingWorld::Release(const qcIsland& island)
{
    Piece& first = m_pieces[island.pieces[0]];
    btRigidBody* before = first.island != nullptr ? first.island->body.get() : first.body.get();
    qcPieceMotion motion = qcMotionOfIsland(*before, FrameOf(*before), island, double(s_density));
    bool isSingle = island.pieces.size() == 1, isInWorld = isSingle && first.state == qc_pieceStanding;
    btRigidBody* body = isSingle ? first.body.get() : Join(island, motion);
    body->setWorldTransform(motion.transform);
    body->setInterpolationWorldTransform(motion.transform);
    if (!isInWorld)
        m_world.addRigidBody(body);
    btVector3 inertia = island.inertia * motion.mass, lower, upper;
    qcThawBody(body, motion.mass, inertia, m_world.getGravity());
    if (isSingle)
    {
        first.state = qc_pieceSingle;
        first.island = nullptr;
        m_settling.Add(body, motion.mass, inertia);
    }
    body->getAabb(lower, upper);
    m_settling.WakeIn(lower, upper);
    body->setLinearVelocity(motion.linearVelocity);
    body->setAngularVelocity(motion.angularVelocity);
    // The world has applied the gravity of this step before the body could move.
    body->applyGravity();
}

/// Makes one body of several pieces.
btRigidBody* qcBreakingWorld::Join(const qcIsland& island, const qcPieceMotion& motion)
{
    auto joined = std::make_unique<Island>();
    joined->island = island;
    for (uint32_t index : island.pieces)
    {
        Piece& piece = m_pieces[index];
        if (piece.state == qc_pieceStanding)
            m_world.removeRigidBody(piece.body.get());
        piece.state = qc_pieceInIsland;
        piece.island = joined.get();
        joined->shape.addChildShape(island.frame.inverse() * m_model.fracture.pieces[index].frame,
                                    m_model.shapes[index].get());
    }
    joined->body = std::make_unique<btRigidBody>(
        Material(motion.mass, &joined->shape, island.inertia * motion.mass, motion.transform));
    joined->body->setUserPointer(joined.get());
    m_islands.push_back(std::move(joined));
    return m_islands.back()->body.get();
}

/// Makes bodies of islands that have broken off. Returns their number.
size_t qcBreakingWorld::Separate()
{
    size_t count = 0;
    std::vector<Island*> broken;
    for (const qcIsland& island : qcFindIslands(m_model.fracture, m_bondEnergies))
    {
        const Piece& first = m_pieces[island.pieces[0]];
        bool stands =
            first.state == qc_pieceStanding && std::any_of(island.pieces.begin(), island.pieces.end(),
                                                           [this](uint32_t piece) { return m_model.grounded[piece]; });
        bool isSame = first.state == qc_pieceSingle ||
                      (first.island != nullptr && first.island->island.pieces.size() == island.pieces.size());
        if (stands || isSame)
            continue;
        if (first.island != nullptr && std::find(broken.begin(), broken.end(), first.island) == broken.end())
            broken.push_back(first.island);
        Release(island);
        count++;
    }
    for (Island* island : broken)
    {
        m_world.removeRigidBody(island->body.get());
        m_islands.erase(
            std::find_if(m_islands.begin(), m_islands.end(), [&](const auto& other) { return other.get() == island; }));
    }
    return count;
}

bool qcBreakingWorld::Break()
{
    double start = qcStopwatch_NowMs();
    std::vector<Impact> impacts = FindImpacts();
    if (impacts.empty() && m_blow.bodyB != nullptr)
        impacts.push_back(m_blow);
    m_blow = Impact();
    for (const Impact& impact : impacts)
    {
        Strike(impact);
        if (impact.bodyA == &m_bunny || impact.bodyA == nullptr)
            m_crane.NoteImpact();
    }
    size_t count = impacts.empty() ? 0 : Separate();
    m_newPieces += count;
    m_breakMs += qcStopwatch_NowMs() - start;
    return count > 0;
}

//  ---- steps -----------------------------------------------------------------------------------------

/// Fills the measures at the end of a step.
void qcBreakingWorld::Measure(qcBreakingStep* step) const
{
    step->newPieces = m_newPieces;
    for (const Piece& piece : m_pieces)
        step->loosePieces += piece.state != qc_pieceStanding;
    step->brokenBonds = size_t(std::count(m_bondEnergies.begin(), m_bondEnergies.end(), 0.0));
    step->pairs = m_broadphase.getOverlappingPairCache()->getNumOverlappingPairs();
    const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
        step->bodies += !objects[i]->isStaticObject();
    step->resting = m_settling.RestingCount();
    for (int m = 0; m < m_dispatcher.getNumManifolds(); m++)
    {
        const btPersistentManifold& manifold = *m_dispatcher.getManifoldByIndexInternal(m);
        step->points += manifold.getNumContacts();
        for (int i = 0; i < manifold.getNumContacts(); i++)
            step->penetration = std::max(step->penetration, -manifold.getContactPoint(i).getDistance());
    }
    step->limited = m_meshContact.getStatistics().limited;
    step->unproven = m_meshContact.getStatistics().unproven;
}

bool qcBreakingWorld::Step(qcBreakingStep* step, std::string* message)
{
    m_queries.clear();
    m_newPieces = 0;
    m_breakMs = 0;
    m_crane.Update(btScalar(stepSeconds));
    m_settling.Wake();
    m_bunnySpeed = m_crane.IsCarrying() ? btScalar(0) : m_bunny.getLinearVelocity().length();
    step->costs = qcTimeStep(&m_world, stepSeconds);
    m_settling.Settle(btScalar(stepSeconds));
    NoteBlow();
    step->costs.Move(qc_costRest, qc_costBreak, m_breakMs);
    for (const qcMeshContactStatistics& query : m_queries)
        step->costs.MoveQuery(query);
    const qcMeshContactStatistics& statistics = m_meshContact.getStatistics();
    step->method = statistics.method;
    step->fallback = statistics.fallback;
    Measure(step);
    if (statistics.status != qc_statusOk)
        *message = std::string("contact of meshes: ") + qcStatus_Name(statistics.status);
    return statistics.status == qc_statusOk;
}
