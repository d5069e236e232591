/* MuJoCo's forward dynamics behind the common signature, state = (q, v, u): the minimal pipeline, no contacts or passive forces. */
#include <mujoco/mujoco.h>
#include <string.h>

static const mjModel *model;
static mjData *data;

/* Returns 0, or 1 with the reason in error. */
int peer_setup(const char *path, char *error, int size)
{
    model = mj_loadXML(path, NULL, error, size);
    if (model == NULL)
        return 1;
    data = mj_makeData(model);
    return data == NULL;
}

void peer_function(double *a, const double *state, const double *parameters, const double *time)
{
    const double *u = state + 2 * model->nv;
    const size_t bytes = (size_t)model->nv * sizeof(double);
    memcpy(data->qpos, state, bytes);
    memcpy(data->qvel, state + model->nv, bytes);
    (void)parameters, (void)time;
    mj_kinematics(model, data);
    mj_comPos(model, data);
    mj_makeM(model, data);
    mj_factorM(model, data);
    mj_comVel(model, data);
    mj_rne(model, data, 0, data->qfrc_bias);
    for (int i = 0; i < model->nv; ++i)
        data->qfrc_smooth[i] = u[i] - data->qfrc_bias[i];
    mj_solveM(model, data, a, data->qfrc_smooth, 1);
}
