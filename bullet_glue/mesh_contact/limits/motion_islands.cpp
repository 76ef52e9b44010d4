// Islands of objects that would pass each other in a step.
#include "mesh_contact/limits/motion_islands.h"

#include <algorithm>

namespace
{
/// The translation with the momentum of the objects' own motions, along the axes that none of them is locked to.
btVector3 MeanTranslation(const std::vector<qcSweptObject*>& members)
{
    btVector3 sum(0, 0, 0), free(1, 1, 1);
    btScalar mass = 0;
    for (const qcSweptObject* swept : members)
    {
        btScalar own = 1 / swept->body->getInvMass();
        mass += own;
        sum += (swept->target.getOrigin() - swept->start.getOrigin()) * own;
        for (int axis = 0; axis < 3; axis++)
            free[axis] = swept->body->getLinearFactor()[axis] == 0 ? btScalar(0) : free[axis];
    }
    return sum * free / mass;
}

/// The part of a translation that pushes none of the objects into its floors.
btVector3 StopAtFloors(const std::vector<qcSweptObject*>& members, btVector3 translation)
{
    for (const qcSweptObject* swept : members)
        for (const qcSweptFloor& floor : swept->floors)
        {
            const btScalar room = std::max(floor.HeightOf(*swept->hull, swept->start), btScalar(0));
            translation += floor.normal * std::max(-translation.dot(floor.normal) - room, btScalar(0));
        }
    return translation;
}
} // namespace

void qcMotionIslands::Reset(const std::vector<qcSweptObject*>& objects)
{
    m_objects = objects;
    m_sets.Reset(objects.size());
    m_islands.assign(objects.size(), Island());
    for (size_t i = 0; i < objects.size(); i++)
        objects[i]->index = uint32_t(i);
}

void qcMotionIslands::AddCarrier(Island* island, const qcSweptObject* carrier) const
{
    const qcSweptObject* other = island->carrier;
    if (other == nullptr)
        island->carrier = carrier;
    else if (carrier != nullptr && carrier != other && (carrier->moves || other->moves))
        island->isHeld = true;
}

void qcMotionIslands::Join(const qcSweptObject& a, const qcSweptObject& b)
{
    const qcSweptObject &free = a.body != nullptr ? a : b, &other = a.body != nullptr ? b : a;
    uint32_t root = m_sets.Find(free.index);
    Island island = m_islands[root];
    if (other.body == nullptr)
        AddCarrier(&island, &other);
    else
    {
        uint32_t second = m_sets.Find(other.index);
        island.isHeld = island.isHeld || m_islands[second].isHeld;
        AddCarrier(&island, m_islands[second].carrier);
        root = m_sets.Unite(root, second);
    }
    island.isUsed = true;
    m_islands[root] = island;
}

bool qcMotionIslands::Hold(const qcSweptObject& free)
{
    Island& island = m_islands[m_sets.Find(free.index)];
    bool changes = !island.isHeld;
    island.isHeld = island.isUsed = true;
    return changes;
}

/// The free objects of each island, by representative.
std::vector<std::vector<qcSweptObject*>> qcMotionIslands::FindMembers() const
{
    std::vector<std::vector<qcSweptObject*>> members(m_objects.size());
    for (qcSweptObject* swept : m_objects)
        if (swept->body != nullptr && m_islands[m_sets.Find(swept->index)].isUsed)
            members[m_sets.Find(swept->index)].push_back(swept);
    return members;
}

void qcMotionIslands::Move()
{
    std::vector<std::vector<qcSweptObject*>> members = FindMembers();
    for (size_t root = 0; root < members.size(); root++)
    {
        const Island& island = m_islands[root];
        bool isCarried = !island.isHeld && island.carrier != nullptr && island.carrier->moves;
        bool isFree = !island.isHeld && island.carrier == nullptr && !members[root].empty();
        btTransform motion =
            isCarried ? island.carrier->end * island.carrier->start.inverse() : btTransform::getIdentity();
        btVector3 mean = isFree ? StopAtFloors(members[root], MeanTranslation(members[root])) : btVector3(0, 0, 0);
        for (qcSweptObject* swept : members[root])
        {
            swept->carried = isCarried ? motion * swept->start : swept->start;
            swept->carried.getOrigin() += mean;
            swept->end = swept->At(swept->fraction);
        }
    }
}

void qcMotionIslands::Damp(const std::set<uint32_t>& numbers) const
{
    for (const std::vector<qcSweptObject*>& members : FindMembers())
    {
        btVector3 momentum(0, 0, 0);
        btScalar mass = 0;
        for (const qcSweptObject* swept : members)
        {
            momentum += swept->body->getLinearVelocity() / swept->body->getInvMass();
            mass += 1 / swept->body->getInvMass();
        }
        for (const qcSweptObject* swept : members)
        {
            if (numbers.count(swept->number) == 0)
                continue;
            btVector3 common = IsFree(*swept) ? momentum / mass : btVector3(0, 0, 0);
            btScalar part = std::max(swept->fraction, btScalar(0.5));
            swept->body->setLinearVelocity(common + (swept->body->getLinearVelocity() - common) * part);
            swept->body->setAngularVelocity(swept->body->getAngularVelocity() * part);
        }
    }
}

const qcSweptObject* qcMotionIslands::CarrierOf(const qcSweptObject& free) const
{
    const Island& island = m_islands[m_sets.Find(free.index)];
    return island.isHeld ? nullptr : island.carrier;
}

bool qcMotionIslands::IsFree(const qcSweptObject& free) const
{
    const Island& island = m_islands[m_sets.Find(free.index)];
    return !island.isHeld && island.carrier == nullptr;
}

bool qcMotionIslands::MoveAsOne(const qcSweptObject& a, const qcSweptObject& b) const
{
    const qcSweptObject* carrier = a.body == nullptr ? &a : b.body == nullptr ? &b : CarrierOf(a);
    if (carrier == nullptr || !carrier->moves || carrier->Deforms())
        return false;
    auto isCarried = [&](const qcSweptObject& swept)
    { return &swept == carrier || (swept.body != nullptr && swept.fraction <= 0 && CarrierOf(swept) == carrier); };
    return isCarried(a) && isCarried(b);
}
