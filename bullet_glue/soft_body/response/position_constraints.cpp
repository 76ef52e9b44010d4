// Projections on positions, as Bullet's own soft-body constraints are. A contact acts towards the side on which its
// points were at the start of the step, when nothing penetrated: Bridson, Fedkiw, Anderson: Robust Treatment of
// Collisions, Contact and Friction for Cloth Animation, 2002, section 6.
#include "soft_body/response/position_constraints.h"

#include "common/shape_triangles.h"
#include "soft_body/response/contact_sides.h"
#include "soft_body/response/force_chains.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>

#include <algorithm>

namespace
{
// Parts of a body that were this share of the thickness apart, or more, when it was cut are layers that lie on each
// other: the whole thickness keeps them apart.
constexpr btScalar s_partedShare = btScalar(0.8);

void AddNodes(qcSceneSoftBody& body, const uint32_t vertices[3], const double weights[3], btScalar sign,
              qcSoftConstraint* constraint)
{
    body.inContact = true;
    constraint->accumulates |= body.topology.ropeCount > 0;
    for (int i = 0; i < 3; i++)
    {
        if (weights[i] == 0.0)
            continue;
        btScalar weight = sign * btScalar(weights[i]);
        btScalar inverseMass = body.InverseMass(vertices[i]);
        qcSceneRigid* const tiedTo = body.TiedTo(vertices[i]);
        constraint->tiedTo[constraint->nodeCount] = tiedTo;
        constraint->isTied = constraint->isTied || tiedTo != nullptr;
        constraint->position[constraint->nodeCount] = &body.positions[vertices[i]];
        constraint->inverseMass[constraint->nodeCount] = inverseMass;
        constraint->weight[constraint->nodeCount++] = weight;
        constraint->inverseEffectiveMass += weight * weight * inverseMass;
        constraint->startOffset += weight * body.start[vertices[i]];
    }
}

/// Reads where the point of the mesh is now.
void ReadPoint(qcSoftConstraint* constraint)
{
    const btTransform& now = constraint->rigid->object->getWorldTransform();
    constraint->point = now * constraint->place;
    constraint->arm = constraint->point - now.getOrigin();
}

/// From the centre of the body that the node moves with.
btVector3 ArmOf(const qcSoftConstraint& constraint, int node)
{
    const qcSceneRigid& rigid = *constraint.tiedTo[node];
    return *constraint.position[node] - rigid.object->getWorldTransform().getOrigin() - rigid.pushed.linear;
}

/// How far a unit impulse along a direction moves the sides apart by the bodies that nodes move with; `largest`: the
/// largest displacement of a node by such an impulse on it alone, with its weight.
btScalar YieldOfTied(const qcSoftConstraint& constraint, const btVector3& direction, btScalar* largest)
{
    btScalar sum = 0;
    for (int i = 0; i < constraint.nodeCount; i++)
    {
        if (constraint.tiedTo[i] == nullptr)
            continue;
        const btVector3 arm = ArmOf(constraint, i);
        const btScalar weight = constraint.weight[i];
        const btScalar own = constraint.tiedTo[i]->DisplacementAt(arm, direction).dot(direction);
        *largest = std::max(*largest, btFabs(weight) * own / direction.length2());
        for (int k = 0; k < constraint.nodeCount; k++)
            if (constraint.tiedTo[k] == constraint.tiedTo[i])
                sum += weight * constraint.weight[k] *
                       constraint.tiedTo[k]->DisplacementBy(ArmOf(constraint, k), direction).At(arm).dot(direction);
    }
    return sum / direction.length2();
}

/// How far a unit impulse along a direction moves the sides apart, times the time step; at least as far as it moves
/// each node: a single movable node of small weight would be thrown away.
btScalar YieldAlong(const qcSoftConstraint& constraint, const btVector3& direction)
{
    btScalar yield = constraint.inverseEffectiveMass;
    if (constraint.rigid != nullptr && direction.length2() > 0)
        yield += constraint.rigid->DisplacementAt(constraint.arm, direction).dot(direction) / direction.length2();
    for (int i = 0; i < constraint.nodeCount; i++)
        yield = std::max(yield, btFabs(constraint.weight[i]) * constraint.inverseMass[i]);
    if (!constraint.isTied || !(direction.length2() > 0))
        return yield;
    btScalar largest = 0;
    const btScalar ofTied = YieldOfTied(constraint, direction, &largest);
    return std::max(yield + ofTied, largest);
}

/// Moves the sides of the constraint apart by `missing`, divided by weight and mass.
void Push(const qcSoftConstraint& constraint, const btVector3& missing)
{
    const btScalar yield = YieldAlong(constraint, missing);
    if (yield <= 0)
        return;
    for (int i = 0; i < constraint.nodeCount; i++)
        *constraint.position[i] += missing * (constraint.weight[i] * constraint.inverseMass[i] / yield);
    for (int i = 0; constraint.isTied && i < constraint.nodeCount; i++)
        if (constraint.tiedTo[i] != nullptr)
            constraint.tiedTo[i]->Push(ArmOf(constraint, i), missing * (constraint.weight[i] / yield));
    if (constraint.rigid != nullptr)
        constraint.rigid->Push(constraint.arm, -missing / yield);
}

/// How far friction moves the sides at most: its impulse is the coefficient times that of the push and of chains. A
/// rigid body may yield along the surface by another amount than along the normal.
btScalar MaxFriction(const qcSoftConstraint& constraint, const btVector3& sliding)
{
    const btScalar ofPush = constraint.friction * constraint.pushed;
    const bool yieldsEvenly = !constraint.isTied && (constraint.rigid == nullptr || !constraint.rigid->CanMove());
    if (yieldsEvenly && constraint.chainFriction <= 0)
        return ofPush;
    const btScalar aside = YieldAlong(constraint, sliding), ofChains = constraint.chainFriction * aside;
    if (yieldsEvenly)
        return ofPush + ofChains;
    const btScalar yield = YieldAlong(constraint, constraint.normal);
    return yield > 0 ? ofPush * aside / yield + ofChains : btScalar(0);
}

/// False: it was satisfied, and nothing has moved.
bool Solve(qcSoftConstraint& constraint)
{
    btVector3 offset = qcOffsetOf(constraint);
    btScalar missing = constraint.distance - constraint.normal.dot(offset);
    const btScalar previous = constraint.accumulates ? constraint.pushed : btScalar(0);
    const btVector3 previousTaken = constraint.accumulates ? constraint.taken : btVector3(0, 0, 0);
    constraint.pushed = previous + missing;
    if (constraint.pushed <= 0)
        constraint.pushed = 0;
    const bool isPushed = constraint.pushed != previous;
    if (!isPushed && constraint.chainFriction <= 0)
        return false;
    Push(constraint, constraint.normal * (constraint.pushed - previous));
    // Coulomb friction takes back sliding since the start.
    btVector3 motion = offset - constraint.startOffset - constraint.conveyed;
    btVector3 sliding = motion - constraint.normal * constraint.normal.dot(motion);
    btVector3 taken = previousTaken;
    if (sliding.length() > SIMD_EPSILON)
    {
        taken += sliding;
        const btScalar length = taken.length(), largest = MaxFriction(constraint, taken);
        if (length > largest)
            taken *= largest / length;
        Push(constraint, previousTaken - taken);
        constraint.taken = taken;
    }
    if (!constraint.accumulates)
        constraint.chainFriction = 0;
    return isPushed || !qcAreSame(taken, previousTaken);
}

/// Sets normal and distance so that each side stays on its side of the other, as at the start of the step. `atOnce`: at
/// the whole thickness.
void Orient(btScalar thickness, const btVector3& normal, bool atOnce, qcSoftConstraint* constraint)
{
    constraint->normal = normal;
    constraint->thickness = thickness;
    btScalar startDistance = normal.dot(constraint->startOffset);
    if (startDistance < 0)
    {
        // The sides have passed each other since.
        constraint->normal = -normal;
        startDistance = -startDistance;
    }
    constraint->distance = atOnce ? thickness : std::min(startDistance, thickness);
    constraint->missing = thickness - constraint->distance;
}

btVector3 PointOf(const btVector3* positions, const uint32_t vertices[3], const double weights[3])
{
    btVector3 point(0, 0, 0);
    for (int i = 0; i < 3; i++)
        point += btScalar(weights[i]) * positions[vertices[i]];
    return point;
}

/// The thickness between two parts of a body that has been cut. The sides of a cut are at one place, and links around
/// it hold them there: parts that were nearer than the thickness may come to half of the distance that they had.
btScalar ThicknessBesideCut(const qcSoftContactView& view)
{
    const btVector3* positions = view.a->cutPositions.data();
    const btScalar distance =
        PointOf(positions, view.verticesA, view.weightsA).distance(PointOf(positions, view.verticesB, view.weightsB));
    return distance < s_partedShare * view.thickness ? distance / 2 : view.thickness;
}

/// True if Bullet's filters keep the bodies from colliding.
bool AreFiltered(const btSoftBody* soft, const btCollisionObject* other)
{
    const btSoftBodyWorldInfo* info = const_cast<btSoftBody*>(soft)->getWorldInfo();
    auto* proxyA = const_cast<btBroadphaseProxy*>(soft->getBroadphaseHandle());
    auto* proxyB = const_cast<btBroadphaseProxy*>(other->getBroadphaseHandle());
    if (info->m_dispatcher == nullptr || info->m_broadphase == nullptr || proxyA == nullptr || proxyB == nullptr)
        return true;
    return !info->m_dispatcher->needsCollision(soft, other) ||
           !info->m_broadphase->getOverlappingPairCache()->needsBroadphaseCollision(proxyA, proxyB);
}

/// True for a contact with a convex surface from inside. Between start and end of the step a node may come in through
/// one face near the edge to another one, which must not push it further in.
bool PushesInwards(const qcSoftConstraint& constraint, const qcSceneRigid& rigid, const qcSceneMesh& mesh)
{
    return constraint.normal.dot(constraint.point - rigid.object->getWorldTransform() * mesh.inside) <= 0;
}

/// True if contacts between two soft bodies, or of one with itself, push them apart.
bool HaveResponse(const qcSceneSoftBody& a, const qcSceneSoftBody& b)
{
    // A body has pairs with itself only where its self-collision is on. Pairs of bodies are filtered here and not
    // gathered from processCollision: Bullet's boxes are of predicted positions, and its constraints may bring together
    // bodies whose boxes were disjoint.
    return &a == &b || !AreFiltered(a.body, b.body);
}
} // namespace

btVector3 qcOffsetOf(const qcSoftConstraint& constraint)
{
    btVector3 offset(0, 0, 0);
    for (int i = 0; i < constraint.nodeCount; i++)
        offset += constraint.weight[i] * *constraint.position[i];
    if (const qcSceneRigid* rigid = constraint.rigid)
        offset -= constraint.point + rigid->Pushed().linear + rigid->Pushed().angular.cross(constraint.arm);
    return offset;
}

bool qcHasResponse(const qcSceneSoftBody& soft, const btCollisionObject* object)
{
    const auto& disabled = soft.body->m_collisionDisabledObjects;
    return soft.CollidesWithRigidBodies() && object->hasContactResponse() && !AreFiltered(soft.body, object) &&
           disabled.findLinearSearch(object) == disabled.size();
}

bool qcHasResponse(const qcSceneSoftBody& soft, const qcSceneRigid& rigid, const qcSceneMesh& mesh)
{
    return (!mesh.isSurface || soft.CollidesWithSurfaces()) && qcHasResponse(soft, rigid.object);
}

bool qcHasResponse(qcSoftBodyScene& scene, uint32_t slotA, uint32_t slotB)
{
    const qcSceneSoftBody *a = scene.Find(slotA), *b = scene.Find(slotB);
    if (a != nullptr && b != nullptr)
        return HaveResponse(*a, *b);
    qcSceneRigid* rigid = nullptr;
    const qcSceneMesh* mesh = scene.meshes.Find(a == nullptr ? slotA : slotB, &rigid);
    return qcHasResponse(a == nullptr ? *b : *a, *rigid, *mesh);
}

bool qcHasResponse(qcSoftBodyScene& scene, const qcPair& pair)
{
    const qcSceneSoftBody *a = scene.Find(pair.bodyA), *b = scene.Find(pair.bodyB);
    auto nodesOf = [](const qcSceneSoftBody& soft, uint32_t triangle)
    { return &soft.topology.indices[3 * size_t(triangle)]; };
    if (a != nullptr && b != nullptr)
    {
        if (a->IsTiedTo(*b, nodesOf(*a, pair.triangleA), nodesOf(*b, pair.triangleB)))
            return false;
    }
    else
    {
        const qcSceneSoftBody& soft = a != nullptr ? *a : *b;
        qcSceneRigid* rigid = nullptr;
        scene.meshes.Find(a == nullptr ? pair.bodyA : pair.bodyB, &rigid);
        if (soft.IsAnchored(nodesOf(soft, a != nullptr ? pair.triangleA : pair.triangleB), rigid->object))
            return false;
    }
    return qcHasResponse(scene, pair.bodyA, pair.bodyB);
}

bool qcViewContact(qcSoftBodyScene& scene, const qcContact& contact, qcSoftContactView* view)
{
    bool swapped = scene.Find(contact.bodyA) == nullptr;
    uint32_t slotA = swapped ? contact.bodyB : contact.bodyA, slotB = swapped ? contact.bodyA : contact.bodyB;
    view->a = scene.Find(slotA);
    view->b = scene.Find(slotB);
    view->verticesA = swapped ? contact.verticesB : contact.verticesA;
    view->verticesB = swapped ? contact.verticesA : contact.verticesB;
    view->weightsA = swapped ? contact.weightsB : contact.weightsA;
    view->weightsB = swapped ? contact.weightsA : contact.weightsB;
    view->normal = swapped ? -qcVectorOf(contact.normal) : qcVectorOf(contact.normal);
    view->distance = btScalar(contact.distance);
    view->onA = PointOf(view->a->positions.data(), view->verticesA, view->weightsA);
    if (view->b != nullptr)
    {
        view->thickness = (view->a->thickness + view->b->thickness) / 2;
        view->friction = (view->a->Friction() + view->b->Friction()) / 2;
        view->onB = PointOf(view->b->positions.data(), view->verticesB, view->weightsB);
        if (view->a == view->b && !view->a->cutPositions.empty())
            view->thickness = ThicknessBesideCut(*view);
        return view->distance <= view->thickness && HaveResponse(*view->a, *view->b) &&
               !view->a->IsTiedTo(*view->b, view->verticesA, view->verticesB);
    }
    const qcSceneMesh& mesh = *scene.meshes.Find(slotB, &view->rigid);
    view->mesh = &mesh;
    view->thickness = mesh.ContactDistance(view->a->thickness);
    view->friction = view->a->FrictionOn(*view->rigid->object);
    view->onB = mesh.sceneTransform * PointOf(mesh.shape->getVertices(), view->verticesB, view->weightsB);
    return view->distance <= view->thickness && qcHasResponse(*view->a, *view->rigid, mesh) &&
           !view->a->IsAnchored(view->verticesA, view->rigid->object);
}

bool qcMakeMeshConstraint(qcSceneSoftBody& soft, const uint32_t vertices[3], const double weights[3],
                          qcSceneRigid& rigid, const qcMeshPlace& place, const btVector3& normal, btScalar thickness,
                          qcSoftConstraint* constraint)
{
    *constraint = qcSoftConstraint();
    AddNodes(soft, vertices, weights, 1, constraint);
    constraint->rigid = &rigid;
    constraint->place = place.point;
    ReadPoint(constraint);
    constraint->startOffset -= rigid.start * place.start;
    constraint->friction = soft.FrictionOn(*rigid.object);
    // What lies on a shape that has other triangles now goes with them at once.
    Orient(thickness, normal, rigid.isReshaped, constraint);
    constraint->conveyed = rigid.ConveyedAt(constraint->point, constraint->normal);
    // Contact wakes the rigid body, as Bullet's own contact of soft bodies does. It moves from the next step on.
    if (soft.moves)
        rigid.Wake();
    return constraint->inverseEffectiveMass > 0 || constraint->isTied || rigid.CanMove();
}

void qcMakeSoftConstraints(qcSoftBodyScene& scene, const qcSoftTangles& tangles, const qcResult& result,
                           std::vector<qcSoftConstraint>* constraints, std::vector<size_t>* contactOf)
{
    constraints->clear();
    contactOf->clear();
    for (size_t i = 0; i < result.contactCount; i++)
    {
        qcSoftContactView view;
        if (!qcViewContact(scene, result.contacts[i], &view) || tangles.IsExempt(result.contacts[i]))
            continue;
        qcSoftConstraint constraint;
        if (view.rigid != nullptr)
        {
            const btVector3 point = view.rigid->object->getWorldTransform().invXform(view.onB);
            const qcMeshPlace place = {point, point - view.mesh->DeformationAt(view.verticesB, view.weightsB)};
            if (!qcMakeMeshConstraint(*view.a, view.verticesA, view.weightsA, *view.rigid, place, view.normal,
                                      view.thickness, &constraint))
                continue;
        }
        else
        {
            AddNodes(*view.a, view.verticesA, view.weightsA, 1, &constraint);
            AddNodes(*view.b, view.verticesB, view.weightsB, -1, &constraint);
            if (constraint.inverseEffectiveMass <= 0 && !constraint.isTied)
                continue;
            constraint.friction = view.friction;
            Orient(view.thickness, view.normal, false, &constraint);
        }
        constraint.isTangled = tangles.AreTangled(result.contacts[i].bodyA, result.contacts[i].bodyB);
        // Parts of tangled bodies are on the wrong side at the start.
        if (!constraint.isTangled && (view.rigid == nullptr || !view.rigid->isReshaped) &&
            !qcOrientByFeatures(view, &constraint))
            continue;
        if (view.rigid != nullptr && view.mesh->isConvex && PushesInwards(constraint, *view.rigid, *view.mesh))
            continue;
        constraints->push_back(constraint);
        contactOf->push_back(i);
    }
}

void qcSolveSoftConstraints(std::vector<qcSoftConstraint>* constraints, qcForceChains* chains, const qcRopeLinks& links,
                            std::vector<qcRigidNodeContact>* rigidNodeContacts, int iterations)
{
    chains->Begin();
    for (qcSoftConstraint& constraint : *constraints)
    {
        constraint.chainFriction = 0;
        if (constraint.rigid != nullptr)
            ReadPoint(&constraint);
    }
    size_t movedCount = 0;
    for (int i = 0; i < iterations; i++)
    {
        // Bullet has solved the links before the first sweep.
        if (i > 0)
            links.Solve();
        bool moved = chains->Solve(constraints);
        for (qcSoftConstraint& constraint : *constraints)
            moved = Solve(constraint) || moved;
        if (!moved && links.IsEmpty() && rigidNodeContacts->empty())
            return;
        // Few of the nodes on rigid bodies are in a contact. The first sweep moves these; the last one checks all
        // nodes.
        if (i == 0)
            movedCount = qcPartitionMovedContacts(rigidNodeContacts);
        qcSolveRigidNodeContacts(rigidNodeContacts, i + 1 < iterations ? movedCount : rigidNodeContacts->size());
    }
}

void qcAddRecovery(std::vector<qcSoftConstraint>* constraints, btScalar share, bool onlyTangled)
{
    for (qcSoftConstraint& constraint : *constraints)
        if (constraint.isTangled || !onlyTangled)
        {
            constraint.distance += share * constraint.missing;
            constraint.missing = 0;
        }
}

void qcSolveWithoutVelocity(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints, qcForceChains* chains,
                            const qcRopeLinks& links, std::vector<qcRigidNodeContact>* rigidNodeContacts,
                            int iterations)
{
    std::vector<std::vector<btVector3>> positions;
    for (const qcSceneSoftBody& soft : scene.Bodies())
        positions.push_back(soft.inContact ? soft.positions : std::vector<btVector3>());
    for (const std::unique_ptr<qcSceneRigid>& rigid : scene.meshes.Rigids())
        rigid->BeginRecovery();
    // Rigid bodies get impulses only for what gives the nodes velocities.
    const std::vector<qcRigidNodeContact> contacts = *rigidNodeContacts;
    qcSolveSoftConstraints(constraints, chains, links, rigidNodeContacts, iterations);
    *rigidNodeContacts = contacts;
    for (size_t i = 0; i < positions.size(); i++)
    {
        qcSceneSoftBody& soft = scene.Bodies()[i];
        if (!positions[i].empty())
            soft.shifts.resize(soft.positions.size(), btVector3(0, 0, 0));
        for (size_t node = 0; node < positions[i].size(); node++)
            soft.shifts[node] += soft.positions[node] - positions[i][node];
    }
    for (const std::unique_ptr<qcSceneRigid>& rigid : scene.meshes.Rigids())
        rigid->EndRecovery();
}

void qcRestoreGaps(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints, qcForceChains* chains,
                   std::vector<qcRigidNodeContact>* rigidNodeContacts, btScalar share, int iterations)
{
    if (std::none_of(constraints->begin(), constraints->end(),
                     [](const qcSoftConstraint& constraint) { return constraint.missing > 0; }))
        return;
    qcAddRecovery(constraints, share, false);
    qcSolveWithoutVelocity(scene, constraints, chains, {}, rigidNodeContacts, iterations);
}
